"""Veach's test of multiple importance sampling (1997, fig. 9.2): plates and ball lamps.

Plates, lamps and camera follow the scene file that is published with Veach and Guibas's figure and
handed round with many renderers. Colours on the lamps tell their reflections apart.
"""

from __future__ import annotations

import math
from pathlib import Path

from .common import Color, SceneInfo, add_bevel, add_camera, add_object, new_scene, save_scene
from .materials import diffuse, emitter, metal
from .shapes import ball, polygons

INFO = SceneInfo(
    name="veach_plates",
    purpose="Veach's plates of differing roughness under lights of differing size: neither light "
    "sampling nor BSDF sampling alone does well everywhere, so it shows what their combination is "
    "worth.",
    resolution=(480, 320),
    exposure=0.4,
)

# Roughness (alpha = roughness^2), then the far and the near edge as (y up, z towards the camera).
_PLATES = (
    (0.06, (-2.70651, 0.25609), (-2.08375, -0.526323)),
    (0.13, (-3.28825, 1.36972), (-2.83856, 0.476536)),
    (0.22, (-3.73096, 2.70046), (-3.43378, 1.74564)),
    (0.34, (-3.99615, 4.0667), (-3.82069, 3.08221)),
)
# Centre x, radius, radiance, colour: each lamp sends out about the same power.
_LAMPS: tuple[tuple[float, float, float, Color], ...] = (
    (-3.75, 0.03333, 901.803, (1.0, 0.32, 0.22)),
    (-1.25, 0.1, 100.0, (1.0, 0.8, 0.25)),
    (1.25, 0.3, 11.1111, (0.3, 0.95, 0.4)),
    (3.75, 0.9, 1.23457, (0.3, 0.5, 1.0)),
)


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    matte = diffuse("Matte", (0.4, 0.4, 0.4))
    # Floor and back wall join in a rounded fold.
    fold = (
        [(-12.0, -4.14615)]
        + [
            (0.5 + 2.0 * math.sin(a), -2.14615 - 2.0 * math.cos(a))
            for a in (math.pi / 2 * i / 24 for i in range(25))
        ]
        + [(2.5, 12.0)]
    )
    vertices = [(x, y, z) for y, z in fold for x in (-14.0, 14.0)]
    faces = [(2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2) for i in range(len(fold) - 1)]
    add_object("Stage", polygons("Stage", vertices, faces, smooth=True), matte)
    for number, (roughness, near, far) in enumerate(_PLATES, 1):
        corners = [
            (-4.0, -near[1], near[0]),
            (4.0, -near[1], near[0]),
            (4.0, -far[1], far[0]),
            (-4.0, -far[1], far[0]),
        ]
        below = [(x, y, z - 0.06) for x, y, z in corners]
        sides = [(i + 4, (i + 1) % 4 + 4, (i + 1) % 4, i) for i in range(4)]
        plate = polygons(
            f"Plate {number}", [*corners, *below], [(0, 1, 2, 3), (7, 6, 5, 4), *sides]
        )
        add_bevel(
            add_object(
                f"Plate {number}",
                plate,
                metal(f"Roughness {roughness}", (0.75, 0.77, 0.8), roughness),
            ),
            0.015,
        )
    for number, (x, radius, radiance, color) in enumerate(_LAMPS, 1):
        name = f"Ball lamp {number}"
        add_object(
            name, ball(name, radius, 32, 16), emitter(name, color, radiance), location=(x, 0.0, 0.0)
        )
    # A weak lamp behind the camera lets the stage be seen.
    add_object(
        "Fill lamp",
        ball("Fill lamp", 0.5, 32, 16),
        emitter("Fill lamp", (1, 1, 1), 260.0),
        location=(10.0, -4.0, 10.0),
    )
    add_camera(
        scene, (0.0, -15.0, 2.0), (0.0, -2.5, -2.0), lens=36.0 / (2 * math.tan(math.radians(19.0)))
    )
    save_scene(scene, path)
