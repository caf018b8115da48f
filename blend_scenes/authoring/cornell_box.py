"""The Cornell box, from the measured data of Cornell University's Program of Computer Graphics.

Geometry: https://www.graphics.cornell.edu/online/box/data.html, one unit there (a millimetre)
being a centimetre here. The spectra are replaced by the RGB reflectances and the RGB radiance that
are customary for this scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import bpy

from .common import SceneInfo, add_camera, add_object, new_scene, save_scene
from .materials import diffuse, emitter
from .shapes import polygons

Corner = tuple[float, float, float]

INFO = SceneInfo(
    name="cornell_box",
    purpose="The Cornell box after its measured data: diffuse interreflection and colour bleeding "
    "under one area light; the plain case that every method must get right.",
    resolution=(384, 384),
    view_transform="Standard",
    exposure=0.7,
)

_WHITE = (0.725, 0.71, 0.68)
_RED = (0.63, 0.065, 0.05)
_GREEN = (0.14, 0.45, 0.091)
_LIGHT = (17.0, 12.0, 4.0)

# Corners as published: x to the left, y up, z away from the camera.
_FLOOR = [(552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)]
_CEILING = [(556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0)]
_LAMP = [(343, 548.8, 227), (343, 548.8, 332), (213, 548.8, 332), (213, 548.8, 227)]
_BACK = [(549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2)]
_RIGHT = [(0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2)]
_LEFT = [(552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0)]
_SHORT_TOP = [(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)]
_TALL_TOP = [(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)]


def _to_blender(points: Sequence[Corner]) -> list[Corner]:
    """Turns published corners into metres with Z up, the box centred on x = 0."""
    return [((278.0 - x) / 100.0, z / 100.0, y / 100.0) for x, y, z in points]


def _block(name: str, top: Sequence[Corner]) -> bpy.types.Mesh:
    """Makes a block from its top's corners, in published units, without its unseen bottom."""
    corners = _to_blender([*top, *((x, 0.0, z) for x, _, z in top)])
    sides = [(i, i + 4, (i + 1) % 4 + 4, (i + 1) % 4) for i in range(4)]
    return polygons(name, corners, [(0, 1, 2, 3), *sides])


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    white = diffuse("White", _WHITE)
    add_object("Floor", polygons("Floor", _to_blender(_FLOOR), [(0, 1, 2, 3)]), white)
    add_object("Back wall", polygons("Back wall", _to_blender(_BACK), [(0, 1, 2, 3)]), white)
    # The lamp fills a hole in the ceiling, so that no two surfaces coincide.
    around = [(i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4) for i in range(4)]
    ceiling = polygons("Ceiling", _to_blender([*_CEILING, *_LAMP]), around)
    add_object("Ceiling", ceiling, white)
    add_object(
        "Left wall", polygons("Left wall", _to_blender(_LEFT), [(0, 1, 2, 3)]), diffuse("Red", _RED)
    )
    add_object(
        "Right wall",
        polygons("Right wall", _to_blender(_RIGHT), [(0, 1, 2, 3)]),
        diffuse("Green", _GREEN),
    )
    add_object("Short block", _block("Short block", _SHORT_TOP), white)
    add_object("Tall block", _block("Tall block", _TALL_TOP), white)
    add_object(
        "Lamp", polygons("Lamp", _to_blender(_LAMP), [(0, 1, 2, 3)]), emitter("Lamp", _LIGHT, 1.0)
    )
    add_camera(scene, (0.0, -8.0, 2.73), (0.0, 0.0, 2.73), lens=35.0, sensor_width=25.0)
    save_scene(scene, path)
