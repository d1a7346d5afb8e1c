"""Writes the control cage of an object as OBJ, with its creases, for earmark.

In Blender: open it in the text editor and run it; the file is written beside the .blend file.
Without a window: blender -b scene.blend -P blender_export.py -- model.obj [object name]
"""
import os
import sys

import bpy


def creases(mesh, attribute, old):
    """Creases of edges or vertices, 0 to 1: an attribute since Blender 4.0, kept elsewhere before."""
    found = mesh.attributes.get(attribute)
    return [item.value for item in found.data] if found else old(mesh)


def old_edges(mesh):
    return [getattr(edge, "crease", 0.0) for edge in mesh.edges]


def old_vertices(mesh):
    layers = getattr(mesh, "vertex_creases", ())
    return [item.value for item in layers[0].data] if len(layers) else []


def sharpness(crease):
    """As Blender gives it to OpenSubdiv; 10 never fades."""
    return 10.0 * crease * crease


def export(obj, path):
    mesh = obj.data
    lines = []
    for vertex in mesh.vertices:
        x, y, z = obj.matrix_world @ vertex.co
        # Blender's z is up; in the file it is y.
        lines.append(f"v {x:.9g} {z:.9g} {-y:.9g}")
    layer = mesh.uv_layers.active
    numbers = {}
    corners = []
    for loop in mesh.loops:
        corner = str(loop.vertex_index + 1)
        if layer:
            # One number per vertex and place: charts stay connected, seams stay open.
            u, v = layer.data[loop.index].uv
            key = (loop.vertex_index, u, v)
            if key not in numbers:
                numbers[key] = len(numbers) + 1
                lines.append(f"vt {u:.9g} {v:.9g}")
            corner += f"/{numbers[key]}"
        corners.append(corner)
    names = [slot.material.name.replace(" ", "_") if slot.material else None for slot in obj.material_slots]
    if any(names):
        library = os.path.splitext(path)[0] + ".mtl"
        lines.insert(0, "mtllib " + os.path.basename(library))
        with open(library, "w", encoding="utf-8") as out:
            for name, slot in zip(names, obj.material_slots):
                if name:
                    color = " ".join(f"{c:.4g}" for c in slot.material.diffuse_color[:3])
                    out.write(f"newmtl {name}\nKd {color}\n")
    current = None
    for polygon in mesh.polygons:
        name = names[polygon.material_index] if names else None
        if name and name != current:
            lines.append("usemtl " + name)
            current = name
        lines.append("f " + " ".join(corners[i] for i in polygon.loop_indices))
    for edge, crease in zip(mesh.edges, creases(mesh, "crease_edge", old_edges)):
        if crease > 0.0:
            a, b = edge.vertices
            lines.append(f"t crease 2/1/0 {a} {b} {sharpness(crease):.6g}")
    for vertex, crease in enumerate(creases(mesh, "crease_vert", old_vertices)):
        if crease > 0.0:
            lines.append(f"t corner 1/1/0 {vertex} {sharpness(crease):.6g}")
    for modifier in obj.modifiers:
        if modifier.type == "SUBSURF" and modifier.boundary_smooth == "ALL":
            lines.append("t interpolateboundary 1/0/0 2")
            break
    with open(path, "w", encoding="utf-8") as out:
        out.write("\n".join(lines) + "\n")


arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
target = arguments[0] if arguments else os.path.splitext(bpy.data.filepath or "model.blend")[0] + ".obj"
export(bpy.data.objects[arguments[1]] if len(arguments) > 1 else bpy.context.object, target)
