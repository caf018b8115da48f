"""A swimming pool in the sun: the floor is seen through waves, and lit through them."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np

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
from .materials import closure, glass, metal, new_material, principled
from .shapes import ball, boxes, grid, spline, tube

INFO = SceneInfo(
    name="pool",
    purpose="A pool floor lit by the sun through waves and seen through the same waves: paths "
    "that are specular, diffuse and specular again, which no eye path finds by chance.",
    resolution=(480, 320),
    samples=2048,
    exposure=-0.8,
)

_LEVEL = -0.12
_DEPTH = -1.5


def _tiles(
    name: str, tints: tuple[tuple[float, float, float], ...], size: float
) -> bpy.types.Material:
    """Glazed tiles with pale joints, over metric UVs."""
    material, nodes = new_material(name)
    uv = nodes.add("TexCoord").outputs["UV"]
    grid_place = nodes.add(
        "VectorMath", {0: uv, 1: (1 / size, 1 / size, 1.0)}, operation="MULTIPLY"
    ).outputs[0]
    checker = nodes.add(
        "TexChecker", {"Vector": grid_place, "Scale": 1.0, "Color1": tints[0], "Color2": tints[1]}
    )
    cell = nodes.add("VectorMath", {0: grid_place}, operation="FRACTION").outputs[0]
    parts = nodes.add("SeparateXYZ", {"Vector": cell})
    edges = [nodes.math("COMPARE", parts.outputs[axis], 0.5) for axis in ("X", "Y")]
    for edge in edges:
        edge.node.inputs[2].default_value = 0.47
    inside = nodes.math("MULTIPLY", *edges)
    color = nodes.mix(inside, (0.7, 0.72, 0.7), checker.outputs["Color"])
    nodes.output(nodes.add("BsdfDiffuse", {"Color": color}).outputs[0])
    return material


def _wave_height() -> Callable[[float, float], float]:
    """A sum of sine waves of many directions: 2 cm high, from 0.3 m to 2 m long."""
    generator = np.random.default_rng(3)
    count = 26
    turn = generator.uniform(0, 2 * math.pi, count)
    length = 0.28 * (1.9 / 0.28) ** generator.random(count)
    phase = generator.uniform(0, 2 * math.pi, count)
    height = 0.0032 * length**0.9 * generator.uniform(0.6, 1.4, count) * 1.25

    def wave(x: float, y: float) -> float:
        along = x * np.cos(turn) + y * np.sin(turn)
        return float(np.sum(height * np.sin(2 * math.pi * along / length + phase)))

    return wave


def _add_ladder() -> None:
    steel = metal("Steel", (0.75, 0.76, 0.78), 0.08)
    for x in (-0.24, 0.24):
        path = spline(
            [
                (x, 0.55, 0.0),
                (x, 0.53, 0.45),
                (x, 0.3, 0.68),
                (x, 0.02, 0.5),
                (x, -0.1, 0.0),
                (x, -0.1, -0.5),
                (x, -0.1, -1.0),
            ],
            8,
        )
        add_object(
            "Ladder rail", tube("Ladder rail", path, 0.02, 16), steel, location=(1.15, 3.0, 0.0)
        )
    for z in (-0.3, -0.58, -0.86):
        step = [((-0.235, -0.14, z), (0.235, -0.06, z + 0.02))]
        add_bevel(
            add_object("Ladder step", boxes("Ladder step", step), steel, location=(1.15, 3.0, 0.0)),
            0.004,
        )


def _ball_material() -> bpy.types.Material:
    """A beach ball: six gores of colour about its axis."""
    material, nodes = new_material("Beach ball")
    u = nodes.add("SeparateXYZ", {"Vector": nodes.add("TexCoord").outputs["UV"]}).outputs["X"]
    color = nodes.ramp(
        u,
        [
            (0.0, (0.75, 0.04, 0.03)),
            (1 / 6, (0.85, 0.85, 0.82)),
            (2 / 6, (0.9, 0.55, 0.02)),
            (3 / 6, (0.85, 0.85, 0.82)),
            (4 / 6, (0.02, 0.2, 0.6)),
            (5 / 6, (0.85, 0.85, 0.82)),
        ],
        "CONSTANT",
    )
    nodes.output(nodes.add("BsdfPrincipled", {"Base Color": color, "Roughness": 0.3}).outputs[0])
    return material


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    set_world(scene, (0.4, 0.65, 1.0), 0.5)
    tiles = _tiles("Pool tiles", ((0.28, 0.62, 0.72), (0.36, 0.7, 0.78)), 0.15)
    band = _tiles("Band", ((0.03, 0.12, 0.35), (0.05, 0.2, 0.45)), 0.075)
    basin = [
        ((-3.2, -4.2, _DEPTH - 0.2), (3.2, 3.2, _DEPTH)),
        ((-3.2, -4.2, _DEPTH), (-3.0, 3.2, -0.3)),
        ((3.0, -4.2, _DEPTH), (3.2, 3.2, -0.3)),
        ((-3.0, 3.0, _DEPTH), (3.0, 3.2, -0.3)),
        ((-3.0, -4.2, _DEPTH), (3.0, -4.0, -0.3)),
    ]
    add_object("Basin", boxes("Basin", basin), tiles)
    rim = [
        ((-3.2, -4.2, -0.3), (-3.0, 3.2, -0.04)),
        ((3.0, -4.2, -0.3), (3.2, 3.2, -0.04)),
        ((-3.0, 3.0, -0.3), (3.0, 3.2, -0.04)),
        ((-3.0, -4.2, -0.3), (3.0, -4.0, -0.04)),
    ]
    add_object("Tile band", boxes("Tile band", rim), band)
    stone = principled("Coping", (0.62, 0.57, 0.48), 0.6)
    coping = []
    for i in range(13):
        x = -3.25 + 0.5 * i
        coping.append(((x, 2.97, -0.04), (x + 0.492, 3.4, 0.0)))
    for side in (-1, 1):
        a, b = sorted((side * 2.97, side * 3.4))
        coping += [
            ((a, -4.2 + 0.51 * i, -0.04), (b, -4.2 + 0.51 * i + 0.502, 0.0)) for i in range(14)
        ]
    add_bevel(add_object("Coping", boxes("Coping", coping), stone), 0.008)
    deck_wood = closure(
        "Deck", "BsdfPrincipled", {"Base Color": (0.2, 0.13, 0.085), "Roughness": 0.65}
    )
    deck = [
        ((-9.0, 3.41 + 0.16 * i, -0.05), (9.0, 3.41 + 0.16 * i + 0.15, -0.01)) for i in range(34)
    ]
    add_bevel(add_object("Deck", boxes("Deck", deck), deck_wood), 0.006)
    lawn = [((-9.0, -6.0, -0.06), (-3.41, 3.4, -0.02)), ((3.41, -6.0, -0.06), (9.0, 3.4, -0.02))]
    add_object("Paving", boxes("Paving", lawn), principled("Paving", (0.4, 0.38, 0.34), 0.8))
    wall = [((-9.0, 8.9, -0.1), (9.0, 9.1, 2.6))]
    add_object(
        "Garden wall", boxes("Garden wall", wall), principled("Whitewash", (0.45, 0.4, 0.33), 0.9)
    )
    add_object(
        "Water",
        grid("Water", (6.0, 7.0), (160, 186), _wave_height()),
        glass("Water", 1.333, 0.0, (0.93, 0.99, 1.0)),
        location=(0.0, -0.5, _LEVEL),
    )
    add_object(
        "Beach ball",
        ball("Beach ball", 0.21, 48, 24),
        _ball_material(),
        location=(-1.15, 0.7, _LEVEL + 0.15),
        rotation=(38, 24, 0),
    )
    _add_ladder()
    sun = add_light("Sun", "SUN", 16.0, (1.0, 0.93, 0.82), (-4.2, -2.0, 5.2), (0.0, 0.0, 0.0))
    sun.data.angle = math.radians(0.53)
    add_camera(scene, (-0.7, -3.4, 2.15), (0.25, 1.2, -0.55), lens=27.0)
    save_scene(scene, path)
