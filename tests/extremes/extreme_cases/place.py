"""Distance from the origin, up to 1e7 units, of objects that are moved and of vertices baked there.

A sphere baked away from the origin has its vertices rounded to what float32 resolves there: its
shape is another, but it stays closed, and closed rooms tell their radiance whatever their shape.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from engine_core.description import Mesh
from scenes import SceneBuilder, box, sphere

from extreme_cases.case import Case, Finite, Needs, Same, Truth, power_of_ten
from extreme_cases.furnaces import after, furnace, unlimited
from extreme_cases.scale import lit

#: Away along no axis.
DIRECTION = np.array([0.71, -0.52, 0.83])


def inward_sphere() -> Mesh:
    shape = sphere(1.0, rings=12, smooth=False)
    shape.corner_vertices = shape.corner_vertices[::-1].copy()
    shape.face_offsets = (shape.face_offsets[-1] - shape.face_offsets[::-1]).astype(np.int32)
    return shape


def baked(kind: str, offset: float) -> SceneBuilder:
    """The room's vertices and the camera there, the object at the origin."""
    shape = box((-1, -1, -1), (1, 1, 1), inward=True) if kind == "box" else inward_sphere()
    away = DIRECTION * offset
    shape.positions = (shape.positions.astype(np.float64) + away).astype(np.float32)
    scene = furnace(0.9, 0.1, shape)
    camera = scene.description.camera
    assert camera is not None
    # In the middle of the vertices as they are.
    camera.transform[:, 3] = (
        0.5 * (shape.positions.min(axis=0).astype(np.float64) + shape.positions.max(axis=0))
    ).astype(np.float32)
    return scene


def moved(offset: float) -> SceneBuilder:
    """The object and the camera there, the vertices about the object's own origin."""
    scene = furnace(0.9, 0.1, inward_sphere())
    d = scene.description
    assert d.camera is not None
    away = (DIRECTION * offset).astype(np.float32)
    d.instances.transform[:, :, 3] = away
    d.camera.transform[:, 3] = away
    return scene


def far_corner(offset: float) -> SceneBuilder:
    """A room about the origin and a speck far away: the middle of all is far from the room."""
    scene = furnace(0.9, 0.1)
    scene.add(box(DIRECTION * offset, DIRECTION * offset + 0.1 * offset))
    return scene


def cases() -> list[Case]:
    found = []
    truth = Truth(after(5, 0.9, 0.1))
    settings = unlimited(5)
    for power in range(1, 8):
        offset = 10.0**power
        name = f"{power_of_ten(offset)} away"
        # The box's corners are rounded to one place from about 1e7 on: there is no room any more.
        resolved = power <= 6
        for kind in ("box", "sphere"):
            found.append(
                Case("place", f"{kind} baked {name}", partial(baked, kind, offset),
                     truth if resolved else Finite(), Needs.ALL_LIGHT, settings, samples=4)
            )  # fmt: skip
            if power in (4, 5):
                found.append(
                    Case("place", f"{kind} baked {name}, many samples",
                         partial(baked, kind, offset), truth, Needs.ALL_LIGHT, settings,
                         samples=1024, large=True)
                )  # fmt: skip
        found.append(
            Case("place", f"sphere moved {name}", partial(moved, offset), truth, Needs.ALL_LIGHT,
                 settings, samples=4)
        )  # fmt: skip
        if power <= 5:
            found.append(
                Case("place", f"room with a speck {name}", partial(far_corner, offset), truth,
                     Needs.ALL_LIGHT, settings, samples=4)
            )  # fmt: skip
    for power in (10, 15, 20):
        # Places on the grid that float32 has there.
        found.append(
            Case("place", f"4096 times as large, {2**power} away", partial(lit, 4096.0, 2.0**power),
                 Same(partial(lit, 4096.0), slack=2e-3), settings={"max_bounces": 4})
        )  # fmt: skip
    return found
