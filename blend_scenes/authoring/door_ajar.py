"""A room whose only light comes round a door left ajar, after Veach's test scene (1997, ch. 11)."""

from __future__ import annotations

from pathlib import Path

import bpy

from .common import SceneInfo, add_bevel, add_camera, add_object, new_scene, save_scene
from .materials import closure, emitter, glass, metal, new_material
from .props import add_framed_picture, add_table, carafe, room_bounds, teapot
from .shapes import box, boxes, grid, lathe, quad
from .surfaces import plaster, wood

INFO = SceneInfo(
    name="door_ajar",
    purpose="A room lit only through a door ajar, by light that has bounced in the next room: "
    "indirect light through a small opening, hard for every path that starts at the eye.",
    resolution=(480, 320),
    samples=1024,
    exposure=1.2,
)

_DOOR_LEFT, _DOOR_RIGHT, _DOOR_TOP = 0.35, 1.25, 2.05
_WALL = (2.0, 2.12)
_ANGLE = 21.0


def _picture() -> bpy.types.Material:
    """An abstract painting: bands of colour by a ramp over the height, blurred by noise."""
    material, nodes = new_material("Painting")
    uv = nodes.coordinates("UV")
    noise = nodes.add("TexNoise", {"Vector": uv, "Scale": 3.0, "Detail": 4.0})
    height = nodes.add("SeparateXYZ", {"Vector": uv}).outputs["Y"]
    place = nodes.math("ADD", height, nodes.math("MULTIPLY", noise.outputs["Fac"], 0.25))
    color = nodes.ramp(
        place,
        [
            (0.2, (0.02, 0.05, 0.12)),
            (0.45, (0.05, 0.22, 0.3)),
            (0.6, (0.75, 0.55, 0.2)),
            (0.9, (0.7, 0.2, 0.06)),
        ],
    )
    nodes.output(nodes.add("BsdfPrincipled", {"Base Color": color, "Roughness": 0.6}).outputs[0])
    return material


def _add_shell() -> None:
    """Both rooms, the wall between them and the door frame."""
    wall = plaster("Wall", (0.78, 0.76, 0.72))
    room = room_bounds((-2.3, -2.6, 0.0), (2.3, _WALL[0], 2.6), 0.1)[1:5]
    floor_wood = wood(
        "Floor", (0.2, 0.1, 0.05), (0.42, 0.24, 0.13), grain=(9.0, 0.7, 9.0), roughness=0.35
    )
    add_object("Room", boxes("Room", room), wall)
    planks = [
        ((-2.3 + 0.2 * i, -2.6, -0.03), (-2.3 + 0.2 * (i + 1) - 0.003, 4.8, 0.0)) for i in range(27)
    ]
    add_object("Floor", boxes("Floor", planks), floor_wood)
    add_object(
        "Under floor",
        quad(
            "Under floor",
            (-2.4, -2.7, -0.04),
            (3.2, -2.7, -0.04),
            (3.2, 4.9, -0.04),
            (-2.4, 4.9, -0.04),
        ),
        wall,
    )
    middle = [
        ((-2.3, _WALL[0], 0.0), (_DOOR_LEFT, _WALL[1], 2.6)),
        ((_DOOR_RIGHT, _WALL[0], 0.0), (3.1, _WALL[1], 2.6)),
        ((_DOOR_LEFT, _WALL[0], _DOOR_TOP), (_DOOR_RIGHT, _WALL[1], 2.6)),
    ]
    add_object("Middle wall", boxes("Middle wall", middle), wall)
    beyond = room_bounds((-2.3, _WALL[1], 0.0), (3.1, 4.8, 2.6), 0.1)
    warm = plaster("Far wall", (0.85, 0.74, 0.56))
    add_object("Next room", boxes("Next room", [beyond[1], beyond[2], beyond[3], beyond[5]]), warm)


def _add_door() -> None:
    """The frame and the leaf, hinged on the right and opening into the next room."""
    paint = closure(
        "Door paint", "BsdfPrincipled", {"Base Color": (0.62, 0.6, 0.55), "Roughness": 0.35}
    )
    y0, y1 = _WALL[0] - 0.02, _WALL[1] + 0.02
    frame = [
        ((_DOOR_LEFT - 0.07, y0, 0.0), (_DOOR_LEFT + 0.015, y1, _DOOR_TOP + 0.07)),
        ((_DOOR_RIGHT - 0.015, y0, 0.0), (_DOOR_RIGHT + 0.07, y1, _DOOR_TOP + 0.07)),
        (
            (_DOOR_LEFT + 0.0155, y0, _DOOR_TOP - 0.015),
            (_DOOR_RIGHT - 0.0155, y1, _DOOR_TOP + 0.07),
        ),
    ]
    add_bevel(add_object("Door frame", boxes("Door frame", frame), paint), 0.004)
    width = _DOOR_RIGHT - _DOOR_LEFT - 0.04
    leaf = [((-width, -0.018, 0.006), (0.0, 0.018, _DOOR_TOP - 0.02))]
    for low, high in ((0.15, 0.85), (1.0, 1.9)):
        for side in (-1, 1):
            a, b = sorted((side * 0.0185, side * 0.026))
            leaf += [
                ((-width + 0.12, a, low), (-width / 2 - 0.04, b, high)),
                ((-width / 2 + 0.04, a, low), (-0.12, b, high)),
            ]
    hinge = (_DOOR_RIGHT - 0.02, _WALL[1] - 0.02, 0.0)
    door = add_object("Door", boxes("Door", leaf), paint, location=hinge, rotation=(0, 0, -_ANGLE))
    add_bevel(door, 0.006)
    brass = metal("Brass", (0.87, 0.65, 0.3), 0.2)
    for side in (-1, 1):
        knob = lathe(
            "Knob",
            [
                (0.0, 0.0),
                (0.022, 0.0),
                (0.022, 0.006),
                (0.009, 0.01),
                (0.009, 0.035),
                (0.024, 0.045),
                (0.028, 0.058),
                (0.02, 0.07),
                (0.0, 0.073),
            ],
            32,
        )
        item = add_object(
            "Knob",
            knob,
            brass,
            location=(-width + 0.06, side * 0.018, 0.98),
            rotation=(90 if side < 0 else -90, 0, 0),
        )
        item.parent = door


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    _add_shell()
    _add_door()
    # Out of sight of the first room: no path of one bounce reaches it.
    add_object(
        "Lamp",
        quad("Lamp", (1.7, 2.8, 2.5), (1.7, 4.2, 2.5), (2.9, 4.2, 2.5), (2.9, 2.8, 2.5)),
        emitter("Lamp", (1.0, 0.82, 0.58), 700.0),
    )
    add_framed_picture(
        "Painting",
        (0.9, 0.62),
        _picture(),
        closure("Frame", "BsdfPrincipled", {"Base Color": (0.03, 0.025, 0.02), "Roughness": 0.3}),
        (-0.85, _WALL[0], 1.55),
    )
    oak = wood("Oak", (0.2, 0.095, 0.04), (0.45, 0.26, 0.12), roughness=0.3)
    add_table("Table", (1.5, 0.72), 0.74, oak, (-0.62, 0.0, 0.0))
    top = 0.741
    add_object(
        "Ceramic teapot",
        teapot("Ceramic teapot", 1.25),
        closure(
            "Glaze",
            "BsdfPrincipled",
            {"Base Color": (0.07, 0.2, 0.32), "Roughness": 0.55, "Coat Weight": 0.6},
        ),
        location=(-1.02, 0.02, top),
        rotation=(0, 0, 200),
    )
    add_object(
        "Metal teapot",
        teapot("Metal teapot", 1.35),
        metal("Silver", (0.93, 0.9, 0.86), 0.12),
        location=(-0.5, 0.1, top),
        rotation=(0, 0, -25),
    )
    add_object(
        "Glass carafe", carafe("Glass carafe"), glass("Glass", 1.5), location=(-0.1, -0.08, top)
    )
    add_object(
        "Cloth",
        grid("Cloth", (0.9, 0.4), (40, 16), lambda x, y: 0.0015, smooth=True),
        closure(
            "Linen",
            "BsdfPrincipled",
            {"Base Color": (0.6, 0.08, 0.05), "Roughness": 0.9, "Sheen Weight": 0.5},
        ),
        location=(-0.6, 0.02, 0.7395),
        rotation=(0, 0, 4),
    )
    add_bevel(
        add_object(
            "Skirting",
            box("Skirting", (2.55, 0.015, 0.11)),
            closure(
                "Skirting", "BsdfPrincipled", {"Base Color": (0.62, 0.6, 0.55), "Roughness": 0.4}
            ),
            location=(-1.0, _WALL[0] - 0.0085, 0.0),
        ),
        0.003,
    )
    add_camera(scene, (-0.75, -1.75, 1.32), (-0.12, 1.0, 0.93), lens=27.0)
    save_scene(scene, path)
