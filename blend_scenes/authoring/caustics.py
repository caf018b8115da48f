"""Glass and metal on a table under one small light."""

from __future__ import annotations

import math
from pathlib import Path

import bpy

from .common import (
    SceneInfo,
    add_bevel,
    add_camera,
    add_light,
    add_object,
    new_scene,
    save_scene,
    set_world,
)
from .materials import glass, metal, principled
from .props import goblet
from .shapes import ball, grid, lathe, polygons
from .surfaces import plaster

INFO = SceneInfo(
    name="caustics",
    purpose="Glass and metal casting caustics from a small light onto a matte table: light that "
    "reaches a diffuse surface by way of specular ones.",
    resolution=(480, 320),
    samples=2048,
)


def _prism() -> bpy.types.Mesh:
    """An equilateral prism lying on its side, 0.14 m long, edges of 0.06 m."""
    side, length = 0.06, 0.07
    height = side * math.sqrt(3.0) / 2.0
    ends = [
        (x, y, z)
        for x in (-length, length)
        for y, z in ((-side / 2, 0.0), (side / 2, 0.0), (0.0, height))
    ]
    return polygons("Prism", ends, [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)])


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    set_world(scene, (0.45, 0.6, 1.0), 0.012)
    # A backdrop that curves up behind the table, without a visible horizon.
    add_object(
        "Backdrop",
        grid("Backdrop", (6.0, 4.0), (4, 64), lambda x, y: 1.2 * max(0.0, y - 0.6) ** 2),
        plaster("Table", (0.72, 0.69, 0.64), 90.0, 0.04),
    )
    gold = metal("Gold", (1.0, 0.72, 0.31), 0.03)
    ring = lathe(
        "Ring",
        [(0.132, 0.002), (0.132, 0.04), (0.13, 0.042), (0.128, 0.04), (0.128, 0.002), (0.13, 0.0)],
        128,
        closed=True,
    )
    add_object("Gold ring", ring, gold, location=(0.2, -0.12, 0.001))
    add_object(
        "Glass ball",
        ball("Glass ball", 0.085, 96, 48),
        glass("Glass", 1.52),
        location=(-0.2, -0.03, 0.0855),
    )
    add_object(
        "Goblet", goblet("Goblet"), glass("Crystal", 1.6), location=(-0.02, 0.13, 0.001), scale=1.35
    )
    add_bevel(
        add_object(
            "Prism",
            _prism(),
            glass("Flint", 1.62, color=(0.75, 0.95, 0.9)),
            location=(-0.13, -0.27, 0.001),
            rotation=(0, 0, -28),
        ),
        0.0015,
    )
    add_object(
        "Copper ball",
        ball("Copper ball", 0.045, 96, 48),
        metal("Copper", (0.95, 0.5, 0.33), 0.06),
        location=(0.24, 0.13, 0.0455),
    )
    add_object(
        "Clay ball",
        ball("Clay ball", 0.034, 64, 32),
        principled("Clay", (0.55, 0.16, 0.1), 0.8),
        location=(0.06, -0.25, 0.0345),
    )
    add_light(
        "Small light", "POINT", 40.0, (1.0, 0.9, 0.75), (0.42, 0.95, 0.72), shadow_soft_size=0.02
    )
    add_camera(scene, (-0.06, -1.0, 0.62), (0.02, -0.04, 0.085), lens=42.0)
    save_scene(scene, path)
