"""Nodes that read the surface: pictures by Cycles and by Vernier of spheres that glow their values.

Run as a program in a process of its own: `python surface_values.py RESULT.npz`. Every case is a
sphere in a tile of an orthographic picture; both engines take one sample at each pixel's centre.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from emitted_values import emit, socket

TILE, COLUMNS = 40, 10
Node = tuple[str, dict[str, Any], dict[str, Any]]
Case = tuple[str, list[Node], str]


def node(kind: str, inputs: dict[str, Any] | None = None, **params: Any) -> Node:
    return f"ShaderNode{kind}", inputs or {}, params


def coordinate_cases() -> list[Case]:
    cases: list[Case] = []
    outputs = {
        "TexCoord": "Generated Normal UV Object Camera Window Reflection",
        "NewGeometry": "Position Normal Tangent Incoming Backfacing",
        "CameraData": "View_Vector View_Z_Depth View_Distance",
        "ObjectInfo": "Location Color Alpha Object_Index Material_Index Random",
        "LightPath": "Is_Camera_Ray Is_Diffuse_Ray Ray_Length Ray_Depth",
    }
    for kind, names in outputs.items():
        for name in names.split():
            cases.append((f"{kind} {name}", [node(kind)], name.replace("_", " ")))
    cases.append(("TexCoord of another object", [node("TexCoord", object="other")], "Object"))
    cases.append(("Fresnel", [node("Fresnel", {"IOR": 1.4})], "Fac"))
    for blend in (0.3, 0.5, 0.8):
        for output in ("Fresnel", "Facing"):
            cases.append(
                (f"LayerWeight {output} {blend}", [node("LayerWeight", {"Blend": blend})], output)
            )
    for kind in ("VECTOR", "POINT", "NORMAL"):
        for start in ("WORLD", "OBJECT", "CAMERA"):
            for end in {"WORLD", "OBJECT", "CAMERA"} - {start}:
                convert = node(
                    "VectorTransform",
                    {"Vector": (0.3, 0.5, 0.7)},
                    vector_type=kind,
                    convert_from=start,
                    convert_to=end,
                )
                cases.append((f"VectorTransform {kind} {start} {end}", [convert], "Vector"))
    for axis in "XYZ":
        cases.append((f"Tangent {axis}", [node("Tangent", axis=axis)], "Tangent"))
    by_uv = node("Tangent", direction_type="UV_MAP", uv_map="UVMap")
    cases.append(("Tangent of UV", [by_uv], "Tangent"))
    cases.append(("VertexColor", [node("VertexColor", layer_name="Col")], "Color"))
    cases.append(("VertexColor without a name", [node("VertexColor")], "Color"))
    cases.append(("VertexColor without a name, alpha", [node("VertexColor")], "Alpha"))
    cases.append(("Attribute", [node("Attribute", attribute_name="Col")], "Fac"))
    cases.append(("Noise without a vector", [node("TexNoise")], "Color"))
    return sorted(cases)


def image_cases() -> list[Case]:
    cases: list[Case] = []
    placed = [
        node("TexCoord"),
        node(
            "Mapping",
            {"Vector": [0, "UV"], "Scale": (2.3, 1.7, 1.0), "Location": (-0.4, -0.3, 0.0)},
        ),
    ]
    for interpolation in ("Linear", "Closest", "Cubic"):
        for extension in ("REPEAT", "EXTEND", "CLIP", "MIRROR"):
            image = node(
                "TexImage",
                {"Vector": [1, "Vector"]},
                image="colours",
                interpolation=interpolation,
                extension=extension,
            )
            cases.append((f"Image {interpolation} {extension}", [*placed, image], "Color"))
    image = node("TexImage", image="colours")
    cases.append(("Image alpha", [image], "Alpha"))
    over = node(
        "VectorMath", {"Vector": [0, "Color"], "Vector_001": [0, "Alpha"]}, operation="MULTIPLY"
    )
    cases.append(("Image with alpha read", [image, over], "Vector"))
    for projection in ("BOX", "SPHERE", "TUBE"):
        image = node(
            "TexImage",
            {"Vector": [0, "Generated"]},
            image="colours",
            projection=projection,
            projection_blend=0.3,
        )
        cases.append((f"Image {projection}", [node("TexCoord"), image], "Color"))
    for projection in ("EQUIRECTANGULAR", "MIRROR_BALL"):
        image = node(
            "TexEnvironment", {"Vector": [0, "Normal"]}, image="sky", projection=projection
        )
        cases.append((f"Environment {projection}", [node("NewGeometry"), image], "Color"))
    return cases


def normal_cases() -> list[Case]:
    cases: list[Case] = []
    bumps = node("TexImage", image="normals", interpolation="Cubic")
    for space in ("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD"):
        for strength in (1.0, 0.6):
            uv_map = "UVMap" if space == "TANGENT" else ""
            mapped = node(
                "NormalMap",
                {"Color": [0, "Color"], "Strength": strength},
                space=space,
                uv_map=uv_map,
            )
            cases.append((f"NormalMap {space} {strength}", [bumps, mapped], "Normal"))
    noise = node("TexNoise", {"Scale": 2.0, "Detail": 0.0})
    for invert in (False, True):
        bump = node("Bump", {"Height": [0, "Fac"], "Distance": 0.3, "Strength": 0.8}, invert=invert)
        cases.append((f"Bump {invert}", [noise, bump], "Normal"))
    image = node("Bump", {"Height": [0, "Color"], "Distance": 0.3})
    cases.append(("Bump of an image", [bumps, image], "Normal"))
    fine = node("TexNoise", {"Scale": 3.0, "Detail": 0.0})
    first = node("Bump", {"Height": [0, "Fac"], "Distance": 0.2})
    second = node("Bump", {"Height": [2, "Fac"], "Distance": 0.1, "Normal": [1, "Normal"]})
    cases.append(("Bump upon a bump", [noise, first, fine, second], "Normal"))
    return cases


CASES = coordinate_cases() + image_cases() + normal_cases()


def _images(bpy: Any) -> dict[str, Any]:
    rng = np.random.default_rng(3)

    def image(name: str, width: int, height: int, pixels: Any, **options: Any) -> Any:
        result = bpy.data.images.new(name, width, height, **options)
        result.pixels.foreach_set(np.asarray(pixels, np.float32).ravel())
        result.pack()
        return result

    colours = rng.uniform(0, 1, (9, 13, 4))
    normals = rng.uniform(0.35, 0.65, (5, 7, 4))
    normals[..., 2], normals[..., 3] = 0.9, 1.0
    sky = rng.uniform(0, 1, (4, 8, 4))
    sky[..., 3] = 1.0
    return {
        "colours": image("colours", 13, 9, colours, alpha=True),
        "normals": image("normals", 7, 5, normals, is_data=True),
        "sky": image("sky", 8, 4, sky, float_buffer=True),
    }


def _material(bpy: Any, case: Case, things: dict[str, Any]) -> Any:
    name, nodes, output = case
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.pass_index = 7
    tree = material.node_tree
    tree.nodes.clear()
    built = []
    for kind, inputs, params in nodes:
        item = tree.nodes.new(kind)
        built.append(item)
        for key, value in params.items():
            setattr(item, key, things[value] if key in ("image", "object") else value)
        for key, value in inputs.items():
            target = socket(item.inputs, key)
            if isinstance(value, list):
                tree.links.new(socket(built[value[0]].outputs, value[1]), target)
            else:
                target.default_value = value
    emit(tree, socket(built[-1].outputs, output))
    return material


def _sphere(bpy: Any) -> Any:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=20, ring_count=12, radius=0.45)
    sphere = bpy.context.object
    mesh = sphere.data
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.color_attributes.new("Not this one", "FLOAT_COLOR", "POINT")
    # Smooth in space, as what jumps between faces would test the rasters and not the attribute.
    mesh.color_attributes.new("Col", "FLOAT_COLOR", "POINT").data.foreach_set(
        "color", [c for v in mesh.vertices for c in (*(v.co * 0.5), 0.5 + v.co[0])]
    )
    mesh.color_attributes.render_color_index = 1
    bpy.data.objects.remove(sphere)
    return mesh


def _scene(bpy: Any) -> Any:
    scene = bpy.context.scene
    other = bpy.data.objects.new("other", None)
    other.location, other.rotation_euler, other.scale = (3, 2, 1), (0.3, 0.4, 0.5), (2, 1, 0.5)
    scene.collection.objects.link(other)
    things = _images(bpy) | {"other": other}
    mesh = _sphere(bpy)
    rows = -(-len(CASES) // COLUMNS)
    for number, case in enumerate(CASES):
        own = mesh.copy()
        own.materials.append(_material(bpy, case, things))
        item = bpy.data.objects.new(case[0], own)
        item.location = (number % COLUMNS + 0.5, number // COLUMNS + 0.5, 0)
        item.rotation_euler, item.scale = (0.4, 0.2, 0.9), (1.0, 0.9, 0.8)
        item.color, item.pass_index = (0.2, 0.4, 0.6, 0.8), 3
        scene.collection.objects.link(item)
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", max(COLUMNS, rows)
    holder = bpy.data.objects.new("camera", camera)
    holder.location = (COLUMNS / 2, rows / 2, 10)
    scene.collection.objects.link(holder)
    scene.camera = holder
    render = scene.render
    render.resolution_x, render.resolution_y = COLUMNS * TILE, rows * TILE
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", 2
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = 1, False, False
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 0.01
    vernier = scene.vernier
    vernier.samples, vernier.pixel_filter, vernier.filter_width = 1, "BOX", 0.0101
    return scene


def main() -> None:
    sys.path.insert(0, str(Path(__file__).parents[2]))
    import bpy

    import addon

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    addon.register()
    scene = _scene(bpy)
    pictures = {}
    with tempfile.TemporaryDirectory() as folder:
        for engine in ("CYCLES", "VERNIER"):
            scene.render.engine = engine
            scene.render.filepath = str(Path(folder) / f"{engine}.exr")
            bpy.ops.render.render(write_still=True)
            image = bpy.data.images.load(scene.render.filepath)
            pixels = np.empty(image.size[0] * image.size[1] * image.channels, np.float32)
            image.pixels.foreach_get(pixels)
            shape = (image.size[1], image.size[0], image.channels)
            pictures[engine] = pixels.reshape(shape)[..., :3]
    np.savez(sys.argv[1], CYCLES=pictures["CYCLES"], VERNIER=pictures["VERNIER"])
    sys.stdout.flush()
    os._exit(0)  # Blender 4.5 as a module hangs when it exits


if __name__ == "__main__":
    main()
