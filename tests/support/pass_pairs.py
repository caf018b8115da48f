"""The passes of one scene by Cycles and by Vernier.

Run as a program in a process of its own: `python pass_pairs.py RESULT.npz`. It writes arrays named
"PASS ENGINE" by the names of Blender 5, (seeds, height, width, channels).
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

import cycles_pairs
import light_pairs
import numpy as np
from light_cases import add_lamp, set_world

SIZE, SAMPLES, SEEDS = 32, 512, 4
LIGHT_GROUPS = ("diffuse", "glossy", "transmission")
FLAGS = [
    *("z", "position", "normal", "uv", "emit", "environment"),
    *(f"{group}_{part}" for group in LIGHT_GROUPS for part in ("direct", "indirect", "color")),
]


def scene(bpy: Any) -> Any:
    """A block of Principled, balls of metal, glass, leaf, light and veil; beyond them the sky."""
    from blend_scenes.authoring.materials import closure

    result = light_pairs.plain(bpy)
    cycles_pairs.set_up(result, SIZE, SIZE, SAMPLES)
    balls = {
        "metal": ("BsdfAnisotropic", {"Color": (0.9, 0.7, 0.4), "Roughness": 0.3}),
        "glass": ("BsdfGlass", {"Color": (0.9, 0.9, 1.0), "Roughness": 0.0, "IOR": 1.4}),
        "leaf": ("BsdfTranslucent", {"Color": (0.3, 0.7, 0.2)}),
        "glow": ("Emission", {"Color": (1.0, 0.5, 0.2), "Strength": 2.0}),
        "veil": (
            "BsdfPrincipled",
            {"Base Color": (0.2, 0.4, 0.8), "Alpha": 0.5, "Coat Weight": 0.5},
        ),
    }
    for number, (name, (kind, inputs)) in enumerate(balls.items()):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.45)
        ball = bpy.context.object
        ball.location = (1.1 * (number - 2), -1.2, 0.5)
        for polygon in ball.data.polygons:
            polygon.use_smooth = True
        ball.data.materials.append(closure(name, kind, inputs))
    metal = bpy.data.materials["metal"].node_tree
    bent = metal.nodes.new("ShaderNodeNormalMap")
    bent.inputs["Color"].default_value = (0.65, 0.4, 0.9, 1.0)
    surface = next(n for n in metal.nodes if n.bl_idname == "ShaderNodeBsdfAnisotropic")
    metal.links.new(bent.outputs[0], surface.inputs["Normal"])
    add_lamp(result, "AREA", (0.6, -0.4, 3.0), (0.2, 0.3, 0.1), {"energy": 80.0, "size": 1.5})
    set_world(result, (0.3, 0.4, 0.6))
    layer = result.view_layers[0]
    layer.pass_alpha_threshold = 0.6  # the veil leaves normals and UV to what is behind
    for flag in FLAGS:
        setattr(layer, f"use_pass_{flag}", True)
    return result


def read(path: str) -> dict[str, Any]:
    """The layers of a multilayer EXR by Blender 5's names of the passes: (height, width, c)."""
    import bpy
    import OpenImageIO

    from addon.passes import known_passes

    source = OpenImageIO.ImageInput.open(path)
    planes: dict[str, Any] = {}
    part = 0  # Blender 5 writes each pass as a part of its own, Blender 4.5 all as one
    while source.seek_subimage(part, 0):
        pixels = source.read_image(OpenImageIO.FLOAT)
        for number, name in enumerate(source.spec().channelnames):
            planes[name] = pixels[..., number]
        part += 1
    result = {}
    for item in known_passes():
        wanted = [f"{bpy.context.view_layer.name}.{item.blender_name}.{c}" for c in item.channels]
        if all(name in planes for name in wanted):
            result[item.name] = np.stack([planes[name] for name in wanted], axis=-1)
    return result


def main() -> None:
    bpy = cycles_pairs.start()
    built = scene(bpy)
    settings = built.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    arrays: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for engine in cycles_pairs.ENGINES:
            built.render.engine = engine
            passes = []
            for seed in range(1, SEEDS + 1):
                built.cycles.seed = built.vernier.seed = seed
                built.render.filepath = str(Path(folder) / f"{engine}{seed}.exr")
                bpy.ops.render.render(write_still=True)
                passes.append(read(built.render.filepath))
            for name in passes[0]:
                arrays[f"{name} {engine}"] = np.stack([p[name] for p in passes])
    cycles_pairs.finish(sys.argv[1], arrays)


if __name__ == "__main__":
    main()
