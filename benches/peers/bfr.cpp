// bfr: limit evaluation by OpenSubdiv's Bfr, position and both first derivatives in single precision, on one thread.
//
//   bfr MODEL.obj [SMOOTH SHARP] [--repeat K]
//
// SMOOTH and SHARP are the approximation levels (the library's defaults are 2 and 6). Prints one JSON object: nanoseconds of processor
// time per point, best of K rounds (5), and the largest distance from the limit, as a fraction of the bounding box' largest side.
//
//   single    random faces, random (u, v): the surface is initialised for every point, topologies come from the factory's cache
//   prepared  the same points; every surface was initialised and its patch points prepared beforehand, outside the clock
//   grid      17 x 17 points on every face, each surface initialised once per face, inside the clock
//
// The limit that errors are measured against is refinement in double precision by 5 levels and the limit masks there.
#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

using namespace OpenSubdiv;
typedef Bfr::RefinerSurfaceFactory<> Factory;
typedef Bfr::Surface<float> Surface;

static double cpuSeconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

struct Model {
    std::vector<float> points;
    std::vector<int> sizes, corners;
};

static bool readObj(char const *path, Model &model) {
    std::ifstream file(path);
    std::string line;
    while (std::getline(file, line)) {
        std::istringstream in(line);
        std::string key;
        in >> key;
        if (key == "v") {
            float x[3];
            in >> x[0] >> x[1] >> x[2];
            model.points.insert(model.points.end(), x, x + 3);
        } else if (key == "f") {
            int count = 0;
            for (std::string corner; in >> corner; ++count) {
                int i = atoi(corner.c_str());
                model.corners.push_back(i < 0 ? int(model.points.size()) / 3 + i : i - 1);
            }
            model.sizes.push_back(count);
        }
    }
    return !model.sizes.empty();
}

// Boundaries as earmark takes them by default.
static Far::TopologyRefiner *connect(Model const &model) {
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    Far::TopologyDescriptor d;
    d.numVertices = int(model.points.size()) / 3;
    d.numFaces = int(model.sizes.size());
    d.numVertsPerFace = model.sizes.data();
    d.vertIndicesPerFace = model.corners.data();
    typedef Far::TopologyRefinerFactory<Far::TopologyDescriptor> F;
    return F::Create(d, F::Options(Sdc::SCHEME_CATMARK, options));
}

// The same numbers as `earmark bench evaluate` draws.
struct Random {
    uint64_t state = 1;
    uint32_t bits() {
        state = state * 6364136223846793005ull + 1442695040888963407ull;
        return uint32_t(state >> 33);
    }
    float unit() { return float(bits() >> 7) / float(1u << 24); }
};

struct Place {
    int face;
    float uv[2];
};

struct D3 {
    double x[3];
    void Clear(void * = nullptr) { x[0] = x[1] = x[2] = 0; }
    void AddWithWeight(D3 const &o, double w) {
        for (int k = 0; k < 3; ++k) x[k] += w * o.x[k];
    }
};

// One face, ready to be evaluated.
struct Ready {
    Surface surface;
    std::vector<float> points;
    bool init(Factory const &factory, int face, Model const &model) {
        if (!factory.InitVertexSurface(face, &surface)) return false;
        points.resize(3 * surface.GetNumPatchPoints());
        surface.PreparePatchPoints(model.points.data(), 3, points.data(), 3);
        return true;
    }
    void at(float const uv[2], float out[9]) const { surface.Evaluate(uv, points.data(), 3, out, out + 3, out + 6); }
};

static double sink;

template <class F> static double best(int repeat, size_t items, F once) {
    once();
    double least = 1e30;
    for (int i = 0; i < repeat; ++i) {
        double start = cpuSeconds();
        once();
        least = std::min(least, cpuSeconds() - start);
    }
    return least * 1e9 / double(items);
}

// Largest distance from refined limit points, as a fraction of the box.
static double largestError(Model const &model, Factory const &factory) {
    int const levels = 5;
    std::unique_ptr<Far::TopologyRefiner> refiner(connect(model));
    Far::TopologyRefiner::UniformOptions uniform(levels);
    uniform.fullTopologyInLastLevel = true;
    refiner->RefineUniform(uniform);
    Far::PrimvarRefinerReal<double> primvars(*refiner);
    std::vector<D3> points(model.points.size() / 3);
    double lo[3] = {1e30, 1e30, 1e30}, hi[3] = {-1e30, -1e30, -1e30};
    for (size_t i = 0; i < points.size(); ++i)
        for (int k = 0; k < 3; ++k) {
            points[i].x[k] = model.points[3 * i + k];
            lo[k] = std::min(lo[k], points[i].x[k]);
            hi[k] = std::max(hi[k], points[i].x[k]);
        }
    for (int l = 1; l <= levels; ++l) {
        std::vector<D3> next(refiner->GetLevel(l).GetNumVertices());
        primvars.Interpolate(l, points, next);
        points.swap(next);
    }
    std::vector<D3> limit(points.size());
    primvars.Limit(points, limit);

    // Faces of the last level whose cage face is a quad, with the place of their corner 0.
    double worst = 0;
    Ready ready;
    for (int f = 0; f < int(model.sizes.size()); ++f) {
        if (model.sizes[f] != 4 || !ready.init(factory, f, model)) continue;
        struct Item {
            int level, face;
            double u, v;
        };
        std::vector<Item> stack(1, Item{0, f, 0, 0});
        while (!stack.empty()) {
            Item at = stack.back();
            stack.pop_back();
            if (at.level < levels) {
                Far::ConstIndexArray children = refiner->GetLevel(at.level).GetFaceChildFaces(at.face);
                double h = std::ldexp(0.5, -at.level);
                for (int j = 0; j < 4; ++j)
                    stack.push_back(Item{at.level + 1, children[j], at.u + (j == 1 || j == 2 ? h : 0), at.v + (j >= 2 ? h : 0)});
                continue;
            }
            D3 const &want = limit[refiner->GetLevel(levels).GetFaceVertices(at.face)[0]];
            float uv[2] = {float(at.u), float(at.v)}, out[9];
            ready.at(uv, out);
            double d = 0;
            for (int k = 0; k < 3; ++k) d += (out[k] - want.x[k]) * (out[k] - want.x[k]);
            worst = std::max(worst, std::sqrt(d));
        }
    }
    return worst / std::max(hi[0] - lo[0], std::max(hi[1] - lo[1], hi[2] - lo[2]));
}

int main(int argc, char **argv) {
    int repeat = 5, smooth = 2, sharp = 6, given = 0;
    char const *path = nullptr;
    for (int i = 1; i < argc; ++i) {
        if (!strcmp(argv[i], "--repeat") && i + 1 < argc) repeat = atoi(argv[++i]);
        else if (!path) path = argv[i];
        else (given++ ? sharp : smooth) = atoi(argv[i]);
    }
    Model model;
    if (!path || !readObj(path, model)) {
        fprintf(stderr, "usage: bfr MODEL.obj [SMOOTH SHARP] [--repeat K]\n");
        return 2;
    }
    std::unique_ptr<Far::TopologyRefiner> mesh(connect(model));
    Factory::Options options;
    options.SetApproxLevelSmooth(smooth).SetApproxLevelSharp(sharp);
    Factory factory(*mesh, options);
    int const faces = int(model.sizes.size()), grid = 17;

    // Faces of other than four corners are left out: their parameters differ.
    std::vector<int> quads;
    for (int f = 0; f < faces; ++f)
        if (model.sizes[f] == 4) quads.push_back(f);
    size_t const points = quads.size() * grid * grid;
    Random random;
    std::vector<Place> places(std::min<size_t>(points, 1 << 20));
    for (Place &p : places) {
        p.face = quads[size_t((uint64_t(random.bits()) * quads.size()) >> 31)];
        p.uv[0] = random.unit();
        p.uv[1] = random.unit();
    }

    double single = best(repeat, places.size(), [&] {
        Ready ready;
        float out[9];
        for (Place const &p : places)
            if (ready.init(factory, p.face, model)) {
                ready.at(p.uv, out);
                sink += out[0] + out[4] + out[8];
            }
    });
    std::vector<Ready> all(faces);
    double prepare = best(1, quads.size(), [&] {
        for (int f : quads) all[f].init(factory, f, model);
    });
    double prepared = best(repeat, places.size(), [&] {
        float out[9];
        for (Place const &p : places) {
            all[p.face].at(p.uv, out);
            sink += out[0] + out[4] + out[8];
        }
    });
    std::vector<float> block(9 * grid * grid);
    double onGrid = best(repeat, points, [&] {
        Ready ready;
        for (int f : quads) {
            if (!ready.init(factory, f, model)) continue;
            for (int j = 0; j < grid; ++j)
                for (int i = 0; i < grid; ++i) {
                    float uv[2] = {float(i) / (grid - 1), float(j) / (grid - 1)};
                    ready.at(uv, &block[9 * (j * grid + i)]);
                }
            sink += block[100];
        }
    });
    printf("{\"model\": \"%s\", \"smooth\": %d, \"sharp\": %d, \"faces\": %zu, \"points\": %zu, \"single_ns\": %.1f, \"prepare_ns_per_face\": %.1f, "
           "\"prepared_ns\": %.1f, \"grid_ns\": %.1f, \"largest_error\": %.3g, \"check\": %.9g}\n",
           path, smooth, sharp, quads.size(), points, single, prepare, prepared, onGrid, largestError(model, factory), sink);
    return 0;
}
