"""Materials on spheres, a sphere to a tile, by Cycles and by Vernier.

Run as a program in a process of its own: `python material_sheet.py RESULT.npz SHEET NAME...`. The
sheet `surfaces` has an environment image, a lamp and a sun; `glass` the environment alone, which is
found by sampling the BSDF only.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import cycles_pairs
import numpy as np
from material_cases import CASES

TILE, COLUMNS, SAMPLES, SEEDS = 12, 8, 160, 4


def sphere(bpy: Any) -> Any:
    """A smooth sphere of radius 0.36 with UVs."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.36)
    item = bpy.context.object
    mesh = item.data
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    bpy.data.objects.remove(item)
    return mesh


def add_world(bpy: Any, scene: Any) -> None:
    """An environment image: a coloured gradient with a bright patch."""
    height, width = 64, 128
    v, u = np.mgrid[0:height, 0:width].astype(np.float32)
    v, u = (v + 0.5) / height, (u + 0.5) / width
    sky = np.stack([0.3 + 0.5 * v, 0.4 + 0.3 * u, 0.8 - 0.5 * v, np.ones_like(v)], axis=-1)
    sky[(abs(u - 0.3) < 0.08) & (abs(v - 0.7) < 0.08), :3] = (9.0, 8.0, 6.0)
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(sky.reshape(-1))
    image.pack()
    scene.world = bpy.data.worlds.new("world")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    tree = scene.world.node_tree
    tree.nodes.clear()
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    background = tree.nodes.new("ShaderNodeBackground")
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])


def build(bpy: Any, cases: dict[str, Callable[[Any], Any]], lamps: bool) -> Any:
    """Spheres in rows."""
    scene = bpy.context.scene
    shape = sphere(bpy)
    columns = min(COLUMNS, len(cases))
    rows = -(-len(cases) // columns)
    for number, (name, make) in enumerate(cases.items()):
        mesh = shape.copy()
        mesh.materials.append(make(name))
        item = bpy.data.objects.new(name, mesh)
        item.location = (number % columns + 0.5, rows - number // columns - 0.5, 0)
        item.rotation_euler = (0.5, 0.3, 0.2)
        scene.collection.objects.link(item)
    add_world(bpy, scene)
    if lamps:
        add_lamps(bpy, scene, columns, rows)
    else:
        scene.world.cycles.sampling_method = "NONE"
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", max(columns, rows)
    holder = bpy.data.objects.new("camera", camera)
    holder.location = (columns / 2, rows / 2, 10)
    scene.collection.objects.link(holder)
    scene.camera = holder
    cycles_pairs.set_up(scene, columns * TILE, rows * TILE, SAMPLES)
    return scene


def add_lamps(bpy: Any, scene: Any, columns: int, rows: int) -> None:
    """A broad area lamp and a broad sun."""
    lamp = bpy.data.lights.new("lamp", "AREA")
    lamp.energy, lamp.size, lamp.color = 3000.0, 6.0, (1.0, 0.8, 0.6)
    holder = bpy.data.objects.new("lamp", lamp)
    holder.location = (columns / 2 - 8, rows / 2 + 8, 12)
    holder.rotation_euler = (-0.75, -0.45, 0.0)
    scene.collection.objects.link(holder)
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy, sun.angle, sun.color = 1.5, 0.4, (0.7, 0.8, 1.0)
    holder = bpy.data.objects.new("sun", sun)
    holder.rotation_euler = (0.2, 0.7, 0.0)
    scene.collection.objects.link(holder)


def tiles(pictures: Any, count: int) -> Any:
    """Cuts pictures (seeds, h, w, c) into their tiles: (count, seeds, TILE, TILE, c)."""
    columns = pictures.shape[2] // TILE
    return np.stack(
        [
            pictures[
                :,
                TILE * (i // columns) : TILE * (i // columns + 1),
                TILE * (i % columns) : TILE * (i % columns + 1),
            ]
            for i in range(count)
        ]
    )


def main() -> None:
    bpy = cycles_pairs.start()
    names = sys.argv[3:]
    scene = build(bpy, {name: CASES[name] for name in names}, sys.argv[2] == "surfaces")
    pictures = cycles_pairs.render(scene, SEEDS)
    cycles_pairs.finish(
        sys.argv[1], {engine: tiles(p, len(names)) for engine, p in pictures.items()}
    )


if __name__ == "__main__":
    main()
