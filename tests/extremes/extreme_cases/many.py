"""As many of one thing as nobody has: a plane of ten million instances has a plane's radiance."""

from __future__ import annotations

from functools import partial

import numpy as np
from scenes import SceneBuilder, diffuse, placed, quad

from extreme_cases.case import Case, Needs, Truth
from extreme_cases.shadows import lit_by

ELEVATION = 0.8


def tiled(side: int) -> SceneBuilder:
    """A square floor of `side` by `side` instances of one tile under a sun, seen from above."""
    scene = SceneBuilder((16, 16))
    tile = scene.mesh(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)))
    scene.instance(tile, scene.material(diffuse(0.8)))
    columns, rows = np.meshgrid(np.arange(side), np.arange(side))
    count = side * side
    i = scene.description.instances
    i.transform = np.zeros((count, 3, 4), np.float32)
    i.transform[:, range(3), range(3)] = 1.0
    i.transform[:, 0, 3] = columns.ravel() - 0.5 * side
    i.transform[:, 1, 3] = rows.ravel() - 0.5 * side
    for name in ("mesh", "visibility", "material_set", "random", "object"):
        setattr(i, name, np.repeat(getattr(i, name)[:1], count))
    s, c = np.sin(ELEVATION), np.cos(ELEVATION)
    matrix = np.array([[s, 0, -c], [0, 1, 0], [c, 0, s]])
    scene.light("SUN", emission=(10.0,) * 3, transform=placed(matrix))
    scene.camera((0.3, 0.2, side), (0, 0, 0), fov=40)
    return scene


def cases() -> list[Case]:
    bare = {"max_bounces": 0}
    return [
        Case(
            "many",
            f"{side * side:,} instances",
            partial(tiled, side),
            Truth(lit_by(0.0, ELEVATION)),
            Needs.AIM,
            bare,
            samples=16,
            large=large,
        )
        for side, large in ((100, False), (3163, True))
    ]
