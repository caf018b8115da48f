"""An evening interior whose lamps hide in fixtures: cove strips, closed shades, a glass globe."""

from __future__ import annotations

import math
from pathlib import Path

import bpy

from .common import SceneInfo, add_bevel, add_camera, add_object, new_scene, save_scene
from .materials import diffuse, emitter, glass, metal, new_material, principled
from .props import (
    add_armchair,
    add_framed_picture,
    add_table,
    carafe,
    room_bounds,
    teapot,
    vase,
)
from .shapes import ball, boxes, cylinder, lathe, quad, tube
from .surfaces import marble, plaster, wood

INFO = SceneInfo(
    name="lamp_interior",
    purpose="An evening interior whose lamps are all in fixtures: strips hidden in a cove and "
    "under a shelf, a bulb in an opaque shade, a filament in a glass globe. Little of the room "
    "sees a lamp.",
    resolution=(480, 320),
    samples=1024,
    exposure=0.1,
)

_WARM = (1.0, 0.68, 0.36)


def _add_cove() -> None:
    """A trough along the back wall; the strip lies in it and sees only ceiling and wall."""
    white = principled("Cove", (0.78, 0.76, 0.72), 0.6)
    parts = [((-2.6, 1.75, 2.3), (2.6, 2.2, 2.33)), ((-2.6, 1.75, 2.33), (2.6, 1.78, 2.42))]
    add_bevel(add_object("Cove", boxes("Cove", parts), white), 0.004)
    strip = quad(
        "Cove strip",
        (-2.5, 1.84, 2.345),
        (2.5, 1.84, 2.345),
        (2.5, 1.87, 2.345),
        (-2.5, 1.87, 2.345),
    )
    add_object("Cove strip", strip, emitter("Cove strip", (1.0, 0.78, 0.5), 34.0))


def _add_shelf(walnut: bpy.types.Material) -> None:
    """A shelf with a strip in a groove under its front board, and things to look at."""
    parts = [((-2.25, 1.93, 1.34), (-0.15, 2.2, 1.37)), ((-2.25, 1.93, 1.28), (-0.15, 1.95, 1.339))]
    add_bevel(add_object("Shelf", boxes("Shelf", parts), walnut), 0.003)
    strip = quad(
        "Shelf strip",
        (-2.2, 1.96, 1.335),
        (-2.2, 1.975, 1.335),
        (-0.2, 1.975, 1.335),
        (-0.2, 1.96, 1.335),
    )
    add_object("Shelf strip", strip, emitter("Shelf strip", (1.0, 0.6, 0.3), 60.0))
    covers = ((0.4, 0.06, 0.04), (0.05, 0.12, 0.22), (0.5, 0.36, 0.14), (0.07, 0.2, 0.12))
    x = -2.15
    for i in range(11):
        wide, tall = 0.028 + 0.006 * (i * 7 % 4), 0.2 + 0.018 * (i * 5 % 6)
        book = [((x, 1.97, 1.371), (x + wide, 2.12, 1.371 + tall))]
        add_bevel(
            add_object(
                f"Book {i}", boxes("Book", book), principled(f"Cover {i}", covers[i * 3 % 4], 0.6)
            ),
            0.002,
        )
        x += wide + 0.0015
    add_object(
        "Vase",
        vase("Vase", 0.3),
        principled("Celadon", (0.3, 0.5, 0.42), 0.25, {"Coat Weight": 1.0}),
        location=(-1.35, 2.06, 1.371),
    )
    add_object(
        "Teapot",
        teapot("Teapot", 0.9),
        metal("Pewter", (0.6, 0.58, 0.55), 0.25),
        location=(-0.75, 2.06, 1.371),
        rotation=(0, 0, -20),
    )


def _add_sideboard(walnut: bpy.types.Material) -> None:
    body = [((-2.3, 1.72, 0.16), (-0.1, 2.19, 0.72))]
    body += [
        ((-2.29 + 0.55 * i, 1.7, 0.175), (-2.29 + 0.55 * i + 0.535, 1.719, 0.705)) for i in range(4)
    ]
    body += [((x, y, 0.0), (x + 0.04, y + 0.04, 0.16)) for x in (-2.2, -0.24) for y in (1.8, 2.1)]
    add_bevel(add_object("Sideboard", boxes("Sideboard", body), walnut), 0.004)


def _add_shaded_lamp() -> None:
    """A table lamp: a bulb in an opaque drum, open above and below."""
    place = (-1.9, 1.92, 0.72)
    base = lathe(
        "Lamp base",
        [
            (0.0, 0.0),
            (0.085, 0.0),
            (0.1, 0.04),
            (0.075, 0.13),
            (0.02, 0.2),
            (0.012, 0.3),
            (0.0, 0.3),
        ],
        48,
    )
    add_object(
        "Lamp base", base, principled("Black glaze", (0.02, 0.02, 0.022), 0.15), location=place
    )
    shade = lathe(
        "Shade", [(0.15, 0.27), (0.105, 0.45), (0.102, 0.45), (0.147, 0.27)], 64, closed=True
    )
    add_object("Shade", shade, principled("Shade", (0.75, 0.62, 0.42), 0.5), location=place)
    add_object(
        "Bulb",
        ball("Bulb", 0.022, 24, 12),
        emitter("Bulb", _WARM, 900.0),
        location=(place[0], place[1], place[2] + 0.345),
    )


def _add_dome_pendant() -> None:
    """A metal dome over the table with its bulb deep inside."""
    place = (0.85, 0.35, 1.62)
    dome = [
        (0.21 * math.sin(a), 0.2 * math.cos(a))
        for a in (math.radians(90 - 7.5 * i) for i in range(13))
    ]
    outer = [(max(r, 0.0), z) for r, z in dome]
    outer[-1] = (0.0, 0.2)
    inner = [(0.975 * r, 0.975 * z) for r, z in reversed(outer)]
    dome_mesh = lathe("Dome", [*outer, *inner, outer[0]], 64)
    add_object("Dome", dome_mesh, metal("Brushed copper", (0.9, 0.5, 0.35), 0.25), location=place)
    black = principled("Cable", (0.02, 0.02, 0.02), 0.5)
    add_object(
        "Cable",
        cylinder("Cable", 0.004, 1.1, 12),
        black,
        location=(place[0], place[1], place[2] + 0.198),
    )
    add_object(
        "Dome bulb",
        ball("Dome bulb", 0.03, 24, 12),
        emitter("Dome bulb", _WARM, 380.0),
        location=(place[0], place[1], place[2] + 0.11),
    )


def _add_globe() -> None:
    """A filament in a globe of solid-walled clear glass, beside the armchair."""
    place = (1.95, 1.75, 0.0)
    brass = metal("Brass", (0.88, 0.66, 0.32), 0.18)
    stand = lathe(
        "Globe stand",
        [
            (0.0, 0.0),
            (0.14, 0.0),
            (0.14, 0.015),
            (0.014, 0.028),
            (0.01, 1.24),
            (0.05, 1.26),
            (0.05, 1.275),
            (0.0, 1.275),
        ],
        48,
    )
    add_object("Globe stand", stand, brass, location=place)
    globe = [
        (0.13 * math.sin(a), 1.408 - 0.13 * math.cos(a))
        for a in (math.pi * i / 32 for i in range(33))
    ]
    globe[0], globe[-1] = (0.0, 1.278), (0.0, 1.538)
    hollow = [
        (0.124 * math.sin(a), 1.408 + 0.124 * math.cos(a))
        for a in (math.pi * i / 32 for i in range(33))
    ]
    hollow[0], hollow[-1] = (0.0, 1.532), (0.0, 1.284)
    clear = glass("Globe glass", 1.5)
    add_object("Globe", lathe("Globe", globe, 64), clear, location=place)
    add_object("Globe hollow", lathe("Globe hollow", hollow, 64), clear, location=place)
    coil = [
        (0.03 * math.cos(0.6 * i), 0.03 * math.sin(0.6 * i), 1.37 + 0.0011 * i) for i in range(64)
    ]
    add_object(
        "Filament",
        tube("Filament", coil, 0.004, 8),
        emitter("Filament", _WARM, 1100.0),
        location=place,
    )


def _abstract() -> bpy.types.Material:
    material, nodes = new_material("Print")
    uv = nodes.coordinates("UV", (2.0, 3.0, 1.0))
    noise = nodes.add("TexNoise", {"Vector": uv, "Scale": 1.3, "Detail": 0.0, "Distortion": 0.8})
    color = nodes.ramp(
        noise.outputs["Fac"],
        [
            (0.0, (0.03, 0.06, 0.1)),
            (0.42, (0.55, 0.2, 0.07)),
            (0.5, (0.75, 0.65, 0.48)),
            (0.58, (0.12, 0.25, 0.26)),
        ],
        "CONSTANT",
    )
    nodes.output(nodes.add("BsdfDiffuse", {"Color": color}).outputs[0])
    return material


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    shell = room_bounds((-2.6, -2.6, 0.0), (2.6, 2.2, 2.7), 0.1)
    add_object("Room", boxes("Room", shell[1:]), plaster("Wall", (0.62, 0.6, 0.55)))
    boards = [
        ((-2.6 + 0.16 * i, -2.6, -0.02), (-2.6 + 0.16 * (i + 1) - 0.0025, 2.2, 0.0))
        for i in range(33)
    ]
    add_object(
        "Floor",
        boxes("Floor", boards),
        wood(
            "Floor", (0.14, 0.07, 0.035), (0.32, 0.18, 0.09), grain=(9.0, 0.7, 9.0), roughness=0.32
        ),
    )
    walnut = wood("Walnut", (0.07, 0.03, 0.014), (0.2, 0.1, 0.05), roughness=0.3)
    _add_cove()
    _add_shelf(walnut)
    _add_sideboard(walnut)
    _add_shaded_lamp()
    _add_dome_pendant()
    _add_globe()
    cloth = principled("Moss cloth", (0.09, 0.14, 0.07), 0.9, {"Sheen Weight": 0.5})
    add_armchair(
        (1.45, 1.15, 0.0),
        -32.0,
        cloth,
        walnut,
        principled("Ochre", (0.6, 0.32, 0.06), 0.85, {"Sheen Weight": 0.6}),
    )
    add_table("Table", (0.8, 0.55), 0.45, walnut, (0.72, 0.3, 0.0), 10.0, leg=0.04)
    add_object("Carafe", carafe("Carafe"), glass("Glass", 1.5), location=(0.62, 0.36, 0.451))
    bowl = lathe(
        "Bowl",
        [
            (0.0, 0.0),
            (0.05, 0.0),
            (0.12, 0.06),
            (0.13, 0.085),
            (0.126, 0.085),
            (0.116, 0.064),
            (0.048, 0.006),
            (0.0, 0.006),
        ],
        64,
    )
    add_object(
        "Bowl",
        bowl,
        marble("Bowl", (0.8, 0.78, 0.74), (0.3, 0.3, 0.3), 12.0),
        location=(0.9, 0.22, 0.451),
    )
    fruit = principled("Orange", (0.8, 0.28, 0.02), 0.45)
    for x, y, z in ((0.86, 0.22, 0.5), (0.935, 0.245, 0.5), (0.895, 0.165, 0.51)):
        add_object("Orange", ball("Orange", 0.037, 32, 16), fruit, location=(x, y, z))
    rug = boxes("Rug", [((-0.6, -1.0, 0.0005), (2.0, 0.9, 0.012))])
    add_object("Rug", rug, principled("Rug", (0.2, 0.13, 0.09), 0.95, {"Sheen Weight": 0.5}))
    add_framed_picture(
        "Print", (0.62, 0.8), _abstract(), diffuse("Frame", (0.02, 0.02, 0.02)), (0.55, 2.2, 1.55)
    )
    add_camera(scene, (-0.35, -2.35, 1.35), (0.0, 1.2, 1.05), lens=25.0)
    save_scene(scene, path)
