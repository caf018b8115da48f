"""A hall lit by a thousand small lights, of which each adds a thousandth."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np

from .common import (
    Color,
    SceneInfo,
    add_bevel,
    add_camera,
    add_object,
    new_collection,
    new_scene,
    save_scene,
)
from .materials import emitter, metal, principled
from .props import room_bounds, vase
from .shapes import ball, box, boxes, lathe
from .surfaces import marble, plaster

INFO = SceneInfo(
    name="many_lights",
    purpose="An interior with a thousand small lights, 760 glowing bulbs and 240 lamps: choosing "
    "which light to sample decides the noise.",
    resolution=(480, 320),
    samples=256,
    exposure=0.4,
)

BULBS, LAMPS = 760, 240
_COLORS: tuple[Color, ...] = (
    (1.0, 0.62, 0.28),
    (1.0, 0.8, 0.5),
    (1.0, 0.42, 0.25),
    (0.45, 0.65, 1.0),
)


def _add_bulbs() -> None:
    """A wave of bulbs below the ceiling: four meshes, each shared by many objects."""
    generator = np.random.default_rng(17)
    collection = new_collection("Bulbs")
    meshes = []
    for number, color in enumerate(_COLORS):
        mesh = ball(f"Bulb {number}", 0.024, 10, 6)
        mesh.materials.append(emitter(f"Bulb {number}", color, 16.0))
        meshes.append(mesh)
    columns, rows = 20, 38
    for i in range(BULBS):
        column, row = i % columns, i // columns
        x = -3.3 + 6.6 * (column + 0.5) / columns + 0.08 * generator.standard_normal()
        y = -4.6 + 11.6 * (row + 0.5) / rows + 0.08 * generator.standard_normal()
        z = 3.15 + 0.42 * math.sin(0.9 * y + 0.7 * x) + 0.25 * math.cos(1.7 * x - 0.4 * y)
        kind = generator.choice(4, p=(0.45, 0.35, 0.12, 0.08))
        add_object(
            "Bulb",
            meshes[kind],
            location=(x, y, z + 0.1 * generator.standard_normal()),
            collection=collection,
        )


def _add_lamps() -> None:
    """Rows of point lamps low along both walls; six lamp datablocks in all."""
    collection = new_collection("Lamps")
    data = []
    for number, color in enumerate(((1.0, 0.5, 0.2), (1.0, 0.3, 0.15), (0.9, 0.3, 0.55))):
        lamp = bpy.data.lights.new(f"Lamp {number}", "POINT")
        lamp.energy, lamp.color, lamp.shadow_soft_size = 0.16, color, 0.015
        data.append(lamp)
    half = LAMPS // 2
    for side in (-1, 1):
        for i in range(half):
            y = -4.7 + 11.8 * (i + 0.5) / half
            item = add_object(
                "Lamp",
                data[(i // 8) % 3],
                collection=collection,
                location=(side * 3.42, y, 0.22 + 0.06 * (i % 2)),
            )
            item.visible_camera = False


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    shell = room_bounds((-3.6, -5.0, 0.0), (3.6, 7.4, 4.2), 0.15)
    add_object("Hall", boxes("Hall", shell[1:]), plaster("Wall", (0.16, 0.17, 0.21)))
    tiles = [
        (
            (-3.6 + 0.9 * i, -5.0 + 0.9 * j, -0.05),
            (-3.6 + 0.9 * i + 0.894, -5.0 + 0.9 * j + 0.894, 0.0),
        )
        for i in range(8)
        for j in range(14)
    ]
    add_object(
        "Floor",
        boxes("Floor", tiles),
        marble("Black marble", (0.035, 0.035, 0.04), (0.13, 0.12, 0.11), 0.9, 0.1),
    )
    pillar_mesh = lathe(
        "Pillar",
        [
            (0.0, 0.0),
            (0.3, 0.0),
            (0.3, 0.16),
            (0.25, 0.2),
            (0.2, 0.26),
            (0.19, 2.2),
            (0.17, 3.85),
            (0.24, 3.95),
            (0.3, 4.0),
            (0.3, 4.2),
        ],
        40,
        smooth=False,
    )
    stone = marble("Pale marble", (0.55, 0.52, 0.48), (0.36, 0.33, 0.3), 1.4, 0.25)
    for side in (-1, 1):
        for i in range(5):
            add_object("Pillar", pillar_mesh, stone, location=(side * 2.6, -3.0 + 2.4 * i, 0.0))
    plinth = box("Plinth", (0.55, 0.55, 0.8))
    gold = metal("Gold", (1.0, 0.72, 0.34), 0.12)
    add_bevel(add_object("Plinth", plinth, stone, location=(0.0, 2.2, 0.0)), 0.012)
    add_object("Golden ball", ball("Golden ball", 0.36, 64, 32), gold, location=(0.0, 2.2, 1.16))
    glaze = principled("Glaze", (0.03, 0.12, 0.16), 0.2, {"Coat Weight": 1.0})
    urn = vase("Urn", 1.1)
    for side in (-1, 1):
        for y in (-0.6, 4.2):
            add_object("Urn", urn, glaze, location=(side * 1.35, y, 0.0))
    carpet = [((-0.75, -5.0, 0.0005), (0.75, 7.3, 0.012))]
    add_object(
        "Carpet",
        boxes("Carpet", carpet),
        principled("Carpet", (0.32, 0.025, 0.03), 0.95, {"Sheen Weight": 0.4}),
    )
    arch = [
        ((-1.2, 7.3, 0.0), (-1.0, 7.4, 2.6)),
        ((1.0, 7.3, 0.0), (1.2, 7.4, 2.6)),
        ((-1.2, 7.3, 2.6), (1.2, 7.4, 2.8)),
    ]
    add_bevel(add_object("Portal", boxes("Portal", arch), gold), 0.01)
    _add_bulbs()
    _add_lamps()
    add_camera(scene, (0.55, -4.7, 1.5), (-0.1, 2.0, 1.85), lens=25.0)
    save_scene(scene, path)
