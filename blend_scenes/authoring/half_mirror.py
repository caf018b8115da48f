"""Hughes' surface: half matte, three tenths mirror, two tenths absorbing."""

from __future__ import annotations

import math
from pathlib import Path

import bpy

from .common import (
    SceneInfo,
    add_bevel,
    add_camera,
    add_object,
    new_scene,
    save_scene,
    set_world,
)
from .materials import diffuse, emitter, new_material, principled
from .props import vase
from .shapes import ball, box, boxes, grid, lathe, quad

INFO = SceneInfo(
    name="half_mirror",
    purpose="Hughes' surface (Computer Graphics: Principles and Practice, 3rd ed., fig. 29.3) on "
    "table, ball and screen: 50 % matte, 30 % mirror, 20 % absorbed and nothing transmitted.",
    resolution=(480, 320),
    samples=512,
    exposure=-0.4,
)

MATTE, MIRROR = 0.5, 0.3


def half_mirror(name: str) -> bpy.types.Material:
    """The sum of a Lambertian lobe of albedo 0.5 and a perfect mirror of reflectance 0.3."""
    material, nodes = new_material(name)
    matte = nodes.add("BsdfDiffuse", {"Color": (MATTE, MATTE, MATTE), "Roughness": 0.0})
    mirror = nodes.add("BsdfAnisotropic", {"Color": (MIRROR, MIRROR, MIRROR), "Roughness": 0.0})
    nodes.output(nodes.add("AddShader", {0: matte.outputs[0], 1: mirror.outputs[0]}).outputs[0])
    return material


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    set_world(scene, (0.5, 0.6, 0.8), 0.08)
    surface = half_mirror("Half matte, three tenths mirror")
    add_object(
        "Backdrop",
        grid("Backdrop", (14.0, 9.0), (2, 64), lambda x, y: 0.9 * max(0.0, y - 1.2) ** 2),
        diffuse("Backdrop", (0.32, 0.36, 0.42)),
        location=(0, 0, -0.08),
    )
    table = lathe(
        "Table",
        [(0.0, -0.07), (1.48, -0.07), (1.5, -0.05), (1.5, -0.02), (1.48, 0.0), (0.0, 0.0)],
        128,
        smooth=False,
    )
    add_object("Table", table, surface)
    add_object("Ball", ball("Ball", 0.42, 96, 48), surface, location=(0.0, 0.15, 0.42))
    screen = boxes("Screen", [((-0.55, -0.02, 0.0), (0.55, 0.02, 1.35))])
    add_bevel(
        add_object("Screen", screen, surface, location=(-0.78, 0.72, 0.001), rotation=(0, 0, 24)),
        0.006,
    )
    red = principled("Red", (0.65, 0.04, 0.03), 0.5)
    yellow = principled("Yellow", (0.85, 0.5, 0.03), 0.5)
    blue = principled("Blue", (0.03, 0.12, 0.5), 0.5)
    green = principled("Green", (0.06, 0.4, 0.12), 0.5)
    add_bevel(
        add_object(
            "Cube",
            box("Cube", (0.3, 0.3, 0.3)),
            red,
            location=(-0.62, -0.22, 0.001),
            rotation=(0, 0, 33),
        ),
        0.01,
    )
    cone = lathe("Cone", [(0.0, 0.0), (0.2, 0.0), (0.205, 0.012), (0.012, 0.5), (0.0, 0.507)], 64)
    cone.polygons.foreach_set("use_smooth", [False] * len(cone.polygons))
    add_object("Cone", cone, yellow, location=(0.72, 0.3, 0.001))
    add_object("Vase", vase("Vase", 0.62), blue, location=(0.62, 0.85, 0.001))
    ring = lathe(
        "Ring",
        [
            (0.15 + 0.055 * math.cos(a), 0.055 + 0.055 * math.sin(a))
            for a in (2 * math.pi * (i + 0.5) / 24 for i in range(24))
        ],
        64,
        closed=True,
    )
    add_object("Ring", ring, green, location=(0.42, -0.42, 0.001))
    lamp = emitter("Lamp", (1.0, 0.95, 0.88), 11.0)
    add_object(
        "Lamp",
        quad("Lamp", (-0.7, -0.5, 0), (-0.7, 0.5, 0), (0.7, 0.5, 0), (0.7, -0.5, 0)),
        lamp,
        location=(-1.3, -0.9, 2.9),
        rotation=(24, -24, 0),
    )
    add_object(
        "Cool lamp",
        quad("Cool lamp", (-0.25, -0.9, 0), (-0.25, 0.9, 0), (0.25, 0.9, 0), (0.25, -0.9, 0)),
        emitter("Cool lamp", (0.5, 0.7, 1.0), 6.0),
        location=(2.6, 0.2, 1.5),
        rotation=(0, 70, 0),
    )
    add_camera(scene, (0.25, -3.35, 1.45), (-0.02, 0.1, 0.42), lens=38.0)
    save_scene(scene, path)
