//! Plain data between the processor and the device: every structure here is one of the same name in the WGSL sources, field by field.
//!
//! A test holds the two together through naga, without a GPU ([`Record::layout`]). Buffers are filled word by word ([`Record::put`]),
//! so nothing depends on how this compiler lays structures out beyond `repr(C)`.

/// A field of a record: name, offset and size in bytes.
pub type Field = (&'static str, usize, usize);

/// A structure that Rust and WGSL share.
pub trait Record {
    /// Its name in WGSL.
    const NAME: &'static str;
    /// Bytes of one.
    const SIZE: usize;
    /// All fields in order.
    fn layout() -> Vec<Field>;
    /// Appends its words.
    fn put(&self, out: &mut Vec<u32>);
}

/// Words of a number or of several.
trait Words {
    fn put(&self, out: &mut Vec<u32>);
}

impl Words for u32 {
    fn put(&self, out: &mut Vec<u32>) {
        out.push(*self);
    }
}

impl Words for i32 {
    fn put(&self, out: &mut Vec<u32>) {
        out.push(self.cast_unsigned());
    }
}

impl Words for f32 {
    fn put(&self, out: &mut Vec<u32>) {
        out.push(self.to_bits());
    }
}

impl<T: Words, const N: usize> Words for [T; N] {
    fn put(&self, out: &mut Vec<u32>) {
        for item in self {
            item.put(out);
        }
    }
}

/// Words of a list of records.
#[must_use]
pub fn words<R: Record>(records: &[R]) -> Vec<u32> {
    let mut out = Vec::with_capacity(records.len() * R::SIZE / 4);
    for record in records {
        record.put(&mut out);
    }
    out
}

macro_rules! record {
    ($(#[$about:meta])* $name:ident { $($(#[$field_about:meta])* $field:ident: $kind:ty,)* }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[repr(C)]
        pub struct $name {
            $($(#[$field_about])* pub $field: $kind,)*
        }

        impl Record for $name {
            const NAME: &'static str = stringify!($name);
            const SIZE: usize = size_of::<Self>();
            fn layout() -> Vec<Field> {
                vec![$((stringify!($field), std::mem::offset_of!($name, $field), size_of::<$kind>()),)*]
            }
            fn put(&self, out: &mut Vec<u32>) {
                $(Words::put(&self.$field, out);)*
            }
        }
    };
}

record! {
    /// A picture: view, lights and film. A uniform.
    Frame {
        /// Rows of the projection; see [`Projection`](crate::records::Projection).
        x: [f32; 4],
        /// Row of Y.
        y: [f32; 4],
        /// Row of W.
        w: [f32; 4],
        /// Row of the depth of an orthographic view.
        d: [f32; 4],
        /// Vector to the eye over the screen, in 1/256 pixel: `ray_x * x + (ray_y * y + ray_0)`.
        ray_x: [f32; 4],
        /// Its change down the screen.
        ray_y: [f32; 4],
        /// The vector at the upper left.
        ray_0: [f32; 4],
        /// The eye.
        eye: [f32; 4],
        /// Towards the eye of an orthographic view, and in `w` the offset of distances along the view axis.
        back: [f32; 4],
        /// Unit vector to the key light.
        key_toward: [f32; 4],
        /// Its colour; in `w` how far light wraps around.
        key_color: [f32; 4],
        /// Unit vector to the fill light.
        fill_toward: [f32; 4],
        /// Its colour; in `w` the strength of the highlight.
        fill_color: [f32; 4],
        /// Unit vector to the rim light.
        rim_toward: [f32; 4],
        /// Its colour; in `w` what the highlight gains towards the silhouette.
        rim_color: [f32; 4],
        /// Up.
        up: [f32; 4],
        /// Surround from above; in `w` where the shoulder begins.
        sky: [f32; 4],
        /// Surround from below.
        ground: [f32; 4],
        /// Premultiplied background.
        background: [f32; 4],
        /// Samples in a pixel, 1/256 pixel from its upper left, two by two.
        offsets: [[i32; 4]; 8],
        /// Near distance.
        near: f32,
        /// Distance where depth is 0.
        depth_near: f32,
        /// Distance where depth is 1.
        depth_far: f32,
        /// 1 for an orthographic view.
        ortho: u32,
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Samples per pixel.
        samples: u32,
        /// Number of the shading mode.
        mode: u32,
        /// First row of the band of rows that is drawn.
        band_start: u32,
        /// One past its last row.
        band_end: u32,
        /// 1 where bytes are sRGB.
        srgb: u32,
        /// Bits of a row or column in an id.
        id_bits: u32,
    }
}

record! {
    /// What one chunk of blocks is. A uniform.
    Chunk {
        /// Rank of its first block among all.
        first_rank: u32,
        /// Number of blocks.
        blocks: u32,
        /// Number of corners and points of sides, which stand before the blocks in the points of the chunk.
        spots: u32,
        /// Of the two-pass raster: 0 for depths, 1 for ids.
        phase: u32,
        /// Whether faces are triangles.
        triangles: u32,
        /// Entries that the list of large quads holds.
        large: u32,
        /// Whether faces are patches: [`QAS`](super::wgsl::QAS), [`PN`](super::wgsl::PN), or 0.
        patches: u32,
        /// Weights of a point by a control point: 3 (position, by u, by v) or, for displacement, 6 (by u twice, by both, by v twice).
        width: u32,
        /// The same of texture coordinates: 1 or 3.
        uv_width: u32,
        /// 1 where there are texture coordinates at points.
        textured: u32,
        /// 1 where normals are tilted pixel by pixel.
        tangents: u32,
        /// 1 where faces are cut out by opacity maps.
        cut: u32,
        /// Weights of a colour by a control point, of which the first is read.
        color_width: u32,
        /// 1 where shading reads texture coordinates; outputs beside the picture read those that are there.
        shaded: u32,
        /// 1 where derivatives are differences of a block's points: of interpolating surfaces, which have no formula.
        differences: u32,
        /// Nothing.
        padding: u32,
    }
}

record! {
    /// How the faces of a chunk are displaced. A uniform.
    Rise {
        /// Centre of ripples.
        center: [f32; 4],
        /// What heights come from: one of the shapes of [`wgsl`](super::wgsl).
        shape: u32,
        /// First texel of the map among all heights.
        first: u32,
        /// Texels across.
        width: u32,
        /// Texels down.
        height: u32,
        /// Model units per unit of the map or function.
        scale: f32,
        /// Model units that are added.
        bias: f32,
        /// As [`Function`](crate::displace::Function) has it, here and below.
        frequency: f32,
        /// Frequency of an octave over that of the one before.
        lacunarity: f32,
        /// Strength of an octave over that of the one before.
        gain: f32,
        /// Strength of the first.
        weight: f32,
        /// Time.
        time: f32,
        /// Number of octaves.
        octaves: u32,
        /// Seed.
        seed: u32,
        /// 1 where slopes are taken pixel by pixel.
        per_pixel: u32,
        /// Nothing.
        padding: [u32; 2],
    }
}

record! {
    /// What a spot of a displaced surface takes from elsewhere: one for each spot.
    Lift {
        /// Of patches, where point and normal come from. Quadratic ones: the spots of both ends and of the middle of a curve, in the order first,
        /// middle, last, and a [`pn_place`](super::wgsl::pn_place) on it, whose row is nothing. PN triangles: where control points stand, and
        /// the place, of the point and of the normal.
        curve: [u32; 4],
        /// First entry of the texture coordinates in the list of gathers, of the face that says the position.
        uv_gather: u32,
        /// How many there are.
        uv_count: u32,
        /// First weight of their table, as fine as that of points.
        uv_table: u32,
        /// 1 where nothing moves.
        held: u32,
        /// The same of the face that says the normal.
        own_gather: u32,
        /// How many there are.
        own_count: u32,
        /// First weight of their table.
        own_table: u32,
        /// First of the normals whose mitre the direction is, in the list of gathers: a stencil and a point of its table each, or four words
        /// as those of `curve`, of which PN triangles read the first two.
        mitre: u32,
        /// How many there are; none where the direction is the normal.
        mitre_count: u32,
        /// 1 where there is a curve; other spots of quadratic patches are what curves run through.
        curved: u32,
        /// 1 where the normals of the mitre are those of curves.
        mitre_curves: u32,
        /// Nothing.
        padding: u32,
    }
}

record! {
    /// The control points of a face and its table of weights, a group for each control point and point.
    Stencil {
        /// First entry of its control points in the list of gathers.
        gather: u32,
        /// How many there are.
        count: u32,
        /// First group of its table.
        table: u32,
        /// Groups from one control point to the next.
        stride: u32,
    }
}

record! {
    /// A point on a side or at a corner: its position comes from one face, its normal from one, whoever shares it. Of PN triangles, for a stencil
    /// stands where the control points of a quad are, for a point of a table [`pn_place`](super::wgsl::pn_place).
    Spot {
        /// Stencil of the position.
        stencil: u32,
        /// Point of its table.
        index: u32,
        /// Stencil of the normal.
        normal_stencil: u32,
        /// Point of that table; all bits where the normal is given, and stands at the place of control point `normal_stencil`. All but the
        /// last where it is made of the ring of faces around, which is listed among the gathers there.
        normal_index: u32,
    }
}

record! {
    /// A face that is diced.
    Face {
        /// Spots of the corners.
        corners: [u32; 4],
        /// First spots of the sides.
        sides: [u32; 4],
        /// Of quadratic patches: spots of the corners that they run through.
        base_corners: [u32; 4],
        /// The same of the middles of the sides.
        base_sides: [u32; 4],
        /// Per side eight bits: by how many levels its spots are finer than the face, in bit 7 whether they run the other way, and in bit 6 whether
        /// the side of the face that owns their positions does.
        turns: u32,
        /// Its stencil; of patches, that of the limit surface.
        stencil: u32,
        /// Points of a row of its table.
        row: u32,
        /// By how many levels the table is finer than the face.
        shift: u32,
        /// Level that its blocks' places are given in.
        reach: u32,
        /// Number of the cage's face in the scene.
        number: u32,
        /// Material.
        material: u32,
        /// First entry of its texture coordinates in the list of gathers: where they stand among the control numbers.
        uv_gather: u32,
        /// How many there are; 0 without.
        uv_count: u32,
        /// First weight of their table, as fine as that of points.
        uv_table: u32,
        /// Where colours of the object's vertices begin among the control numbers, counted as if they began at the scene's first control
        /// point; 0 without.
        colors: u32,
        /// Spot of the middle, of quadratic patches; where control points of PN triangles stand.
        middle: u32,
        /// Stencil of colours: as fine as texture coordinates.
        color_stencil: u32,
        /// Nothing.
        padding: [u32; 3],
    }
}

record! {
    /// A block: a square of a face's grid.
    Block {
        /// Its face in the chunk.
        face: u32,
        /// First column, on the face's reach.
        start_x: u32,
        /// First row.
        start_y: u32,
        /// From one point to the next there; 0 where every point has a place of its own, among the moved points.
        step: u32,
        /// Micro-quads along a side, as a power of two.
        log: u32,
        /// First of its points in the points of the chunk.
        base: u32,
        /// First of its moved points.
        moves: u32,
        /// How many there are.
        move_count: u32,
        /// Level that it shows.
        level: u32,
        /// Of a block that is a list of triangles: where they begin in the chunk's lists.
        list: u32,
        /// How many there are; 0 where the micro-quads of the grid are drawn.
        list_count: u32,
        /// Where it stands in the lists which triangles are around each point.
        around: u32,
    }
}

record! {
    /// A point of a block's rim that is elsewhere.
    Move {
        /// Point of the block, row by row.
        at: u32,
        /// Column on the face's reach.
        x: u32,
        /// Row there.
        y: u32,
        /// Nothing.
        padding: u32,
    }
}

record! {
    /// What a face is made of.
    Material {
        /// Linear colour.
        diffuse: [f32; 4],
        /// Where its texture begins among the words of textures, or all bits.
        map: u32,
        /// The same of its opacity map.
        opacity_map: u32,
        /// The same of its normal or bump map.
        relief_map: u32,
        /// What white of a bump map stands for; 0 of a normal map.
        bump: f32,
    }
}

record! {
    /// What is written beside the picture: where the codes of each output begin among the words of a pixel, all bits where it is not
    /// wanted. A uniform.
    Outputs {
        /// What code 0 of positions means.
        position_low: [f32; 4],
        /// What their code 65535 means.
        position_high: [f32; 4],
        /// The same of texture coordinates: u and v of 0, then of 65535.
        uv_range: [f32; 4],
        /// Samples of a pixel, nearest to its centre first.
        order: [[u32; 4]; 4],
        /// Words of a pixel.
        words: u32,
        /// Depth.
        depth: u32,
        /// Normal.
        normal: u32,
        /// Position.
        position: u32,
        /// Colour without light.
        albedo: u32,
        /// Texture coordinates.
        uv: u32,
        /// Face of the cage.
        face: u32,
        /// Level of subdivision.
        level: u32,
        /// Share of the samples that show anything.
        coverage: u32,
        /// Nothing.
        padding: u32,
        /// Nothing.
        more_padding: [u32; 2],
    }
}

record! {
    /// A level of a whole mesh: how much there is, and where lists begin among the words of its buffers. A uniform.
    Mesh {
        /// Vertices.
        vertices: u32,
        /// Edges.
        edges: u32,
        /// Faces.
        faces: u32,
        /// Half-edges.
        halves: u32,
        /// Twins of half-edges, behind their vertices.
        twins: u32,
        /// Edges of half-edges.
        numbers: u32,
        /// First half-edges of vertices, behind half-edges of edges.
        firsts: u32,
        /// Sharpness of edges, then of vertices.
        sharpness: u32,
    }
}

record! {
    /// How blocks are decided by a view: the numbers of the processor's metric. A uniform.
    Metric {
        /// Row of X of the projection; see [`Projection`](crate::records::Projection).
        x: [f32; 4],
        /// Row of Y.
        y: [f32; 4],
        /// Row of W, or of the depth of an orthographic view.
        h: [f32; 4],
        /// The eye.
        eye: [f32; 4],
        /// Unit vector to the right of the picture.
        right: [f32; 4],
        /// Unit vector to its top.
        up: [f32; 4],
        /// Unit vector into it.
        forward: [f32; 4],
        /// Pixels across and down.
        size: [f32; 4],
        /// Where the depth range begins.
        near: f32,
        /// Near distance of the projection.
        plane: f32,
        /// Pixels per model unit, in perspective at distance 1.
        scale: f32,
        /// Per pixel that tests allow.
        pixels: f32,
        /// Per largest chord between unit normals that they allow.
        chord: f32,
        /// Pixels that are allowed as a whole.
        whole_pixels: f32,
        /// Radians that are allowed as a whole.
        whole_radians: f32,
        /// Deepest level of quads.
        max_level: u32,
        /// 1 for an orthographic view.
        ortho: u32,
        /// Nothing.
        padding: u32,
        /// Nothing.
        more_padding: [u32; 2],
    }
}

record! {
    /// A face whose blocks the device decides: one for each [`Face`] of its chunk.
    Patch {
        /// Twice the numbers of the edges at its sides, and one more where an edge runs against the side.
        edges: [u32; 4],
        /// First weight of its 16 control points, if it is a B-spline, for each control point of its stencil: else all bits.
        net: u32,
        /// Irregular corners, bit by bit; [`PATCH_PLAIN`](super::wgsl::PATCH_PLAIN) and what follows there.
        marks: u32,
        /// Nothing.
        padding: [u32; 2],
    }
}

record! {
    /// An edge between such faces.
    Edge {
        /// The face of its first half-edge.
        first: u32,
        /// The other one, or all bits.
        second: u32,
        /// The side of the first face that it is, from bit 2 on that of the second one, and [`EDGE_BACK`](super::wgsl::EDGE_BACK) where that runs
        /// the other way.
        marks: u32,
        /// Nothing.
        padding: u32,
    }
}

record! {
    /// What there is room for in a chunk whose blocks the device decides. A uniform.
    Room {
        /// Blocks.
        blocks: u32,
        /// Points of blocks.
        points: u32,
        /// Moved points.
        moves: u32,
        /// Micro-quads.
        quads: u32,
        /// Spots, which stand before the points.
        spots: u32,
        /// Faces there are.
        faces: u32,
        /// Parts of them whose sums are taken one by one.
        parts: u32,
        /// Nothing.
        padding: u32,
    }
}

record! {
    /// What one pass of the device's own rasteriser draws: a sample of every pixel. A uniform.
    Target {
        /// Number of the sample in its pixel.
        sample: u32,
        /// Clip space per 1/256 pixel: a power of two.
        step: f32,
        /// Nothing.
        padding: [u32; 2],
    }
}

/// Floats of a point of a chunk: position, then unit normal.
pub const POINT_FLOATS: u32 = 6;
