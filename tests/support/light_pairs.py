"""Lights and cameras over a block on the ground, by Cycles and by Vernier.

Run as a program in a process of its own: `python light_pairs.py RESULT.npz NAME...`.
"""

from __future__ import annotations

import sys
from typing import Any

import cycles_pairs
from light_cases import CASES

SIZE, SAMPLES, SEEDS = 24, 256, 4


def plain(bpy: Any) -> Any:
    """A matte ground, a block turned on it and a camera that sees both at an angle."""
    from blend_scenes.authoring.materials import closure

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    cycles_pairs.set_up(scene, SIZE, SIZE, SAMPLES)
    ground = closure("ground", "BsdfDiffuse", {"Color": (0.7, 0.7, 0.7)})
    stone = closure("stone", "BsdfPrincipled", {"Base Color": (0.6, 0.3, 0.2), "Roughness": 0.5})
    for name, material, size, place in (
        ("ground", ground, 6.0, (0.0, 0.0, 0.0)),
        ("block", stone, 1.0, (0.0, 0.0, 0.52)),
    ):
        add = (
            bpy.ops.mesh.primitive_plane_add
            if name == "ground"
            else (bpy.ops.mesh.primitive_cube_add)
        )
        add(size=size, location=place)
        item = bpy.context.object
        item.name = name
        item.rotation_euler.z = 0.4
        item.data.materials.append(material)
    camera = bpy.data.cameras.new("camera")
    holder = bpy.data.objects.new("camera", camera)
    holder.location, holder.rotation_euler = (0.0, -5.0, 5.0), (0.785, 0.0, 0.0)
    scene.collection.objects.link(holder)
    scene.camera = holder
    return scene


def main() -> None:
    bpy = cycles_pairs.start()
    arrays = {}
    for name in sys.argv[2:]:
        scene = plain(bpy)
        CASES[name](scene)
        for engine, pictures in cycles_pairs.render(scene, SEEDS, channels=4).items():
            arrays[f"{name} {engine}"] = pictures
    cycles_pairs.finish(sys.argv[1], arrays)


if __name__ == "__main__":
    main()
