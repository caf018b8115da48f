"""Closed walls keep light out, what touches casts its shadow, and nothing shades itself."""

from __future__ import annotations

from functools import partial

import numpy as np
from engine_core.description import Mesh
from scenes import SceneBuilder, background, box, diffuse, mesh, placed, quad

from extreme_cases.case import Case, Dark, Truth, power_of_ten
from extreme_cases.place import DIRECTION, inward_sphere


def patched(corner: object, u: object, v: object, cells: int) -> Mesh:
    """A parallelogram of many triangles."""
    p, du, dv = (np.array(x, np.float64) for x in (corner, u, v))
    t = np.arange(cells + 1) / cells
    positions = (p + t[:, None, None] * du + t[None, :, None] * dv).reshape(-1, 3)
    faces = []
    for i in range(cells):
        for j in range(cells):
            a = i * (cells + 1) + j
            faces += [(a, a + cells + 1, a + cells + 2), (a, a + cells + 2, a + 1)]
    return mesh("patch", positions, faces)


def closed(kind: str, scale: float, offset: float) -> SceneBuilder:
    """A camera in a closed room; all the light is outside."""
    scene = SceneBuilder((8, 8))
    shape = inward_sphere() if kind == "sphere" else box((-1, -1, -1), (1, 1, 1), inward=True)
    away = DIRECTION * offset
    shape.positions = ((shape.positions.astype(np.float64) + away) * scale).astype(np.float32)
    middle = 0.5 * (shape.positions.min(axis=0) + shape.positions.max(axis=0))
    scene.add(shape, diffuse(0.9))
    d = scene.description
    d.world = background(1e6)
    for direction in ((3, 0.2, 0.1), (-0.3, 3, 0.2), (0.1, -0.2, 3)):
        at = middle + np.array(direction) * scale
        scene.light("POINT", transform=placed(1.0, at), emission=(1e6 * scale**2,) * 3)
    scene.light("SUN", emission=(1e6,) * 3)
    scene.camera((0, 0, 0), (0.3, 1, 0.2), fov=120, clip_start=1e-3 * scale, clip_end=1e9)
    assert d.camera is not None
    d.camera.transform[:, 3] = middle
    return scene


def foot(scale: float, offset: float, thickness: float) -> SceneBuilder:
    """The floor right behind a wall that stands on it, from the side away from the sun.

    The wall is 1 high, the sun 45 degrees high, and the picture a strip of the floor as wide as a
    thousandth of the wall's height beginning at its foot.
    """
    scene = SceneBuilder((8, 8))
    away = DIRECTION * offset
    for corner, u, v in (
        ((-4, -4, 0), (8, 0, 0), (0, 8, 0)),
        ((-4, -thickness, 0), (8, 0, 0), (0, 0, 1)),
    ):
        moved = (np.array(corner) + away) * scale
        scene.add(quad(moved, np.array(u) * scale, np.array(v) * scale), diffuse(0.8))
    # The sun shines from -y, down.
    half = np.sqrt(0.5)
    rows = np.array([[1, 0, 0], [0, half, -half], [0, half, half]])
    scene.light("SUN", emission=(10.0,) * 3, transform=placed(rows))
    strip = 1e-3
    scene.camera((0, 0, 3), (0, 0, 0), kind="ORTHOGRAPHIC")
    d = scene.description
    assert d.camera is not None
    d.camera.transform = placed(
        np.eye(3), (away + np.array((0.0, 0.5 * strip + 1e-5, 0.5))) * scale
    )
    d.camera.window = tuple(0.5 * strip * scale * s for s in (-1, 1, -1, 1))
    d.camera.clip_start, d.camera.clip_end = 1e-6 * scale, 10 * scale
    return scene


def sunlit(slope: float, elevation: float, scale: float, offset: float, many: bool) -> SceneBuilder:
    """A plane of one or of many triangles under a sun: one radiance everywhere."""
    scene = SceneBuilder((16, 16))
    away = DIRECTION * offset
    corner = (np.array((-1.0, -1.0, -slope)) + away) * scale
    u, v = np.array((2.0, 0, 2.0 * slope)) * scale, np.array((0, 2.0, 0)) * scale
    shape = patched(corner, u, v, 23) if many else quad(corner, u, v)
    scene.add(shape, diffuse(0.8))
    s, c = np.sin(elevation), np.cos(elevation)
    # Along -z of the lamp: (c, 0, -s), from low above the plane.
    rows = np.array([[s, 0, -c], [0, 1, 0], [c, 0, s]])
    scene.light("SUN", emission=(10.0,) * 3, transform=placed(rows))
    scene.camera((0.1, 0.2, 4), (0, 0, 0), fov=12)
    d = scene.description
    assert d.camera is not None
    d.camera.transform[:, 3] = (d.camera.transform[:, 3] + away) * scale
    d.camera.clip_start, d.camera.clip_end = 1e-3 * scale, 1e3 * scale
    return scene


def lit_by(slope: float, elevation: float) -> float:
    """The radiance of that plane: irradiance * cosine * albedo / pi."""
    normal = np.array((-slope, 0, 1)) / np.hypot(slope, 1)
    toward_sun = np.array((-np.cos(elevation), 0, np.sin(elevation)))
    return float(10.0 * normal @ toward_sun * 0.8 / np.pi)


def cases() -> list[Case]:
    found = []
    direct: dict[str, object] = {"max_bounces": 3}
    for kind in ("box", "sphere"):
        for scale, offset in ((1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e3), (1.0, 1e5),
                              (1e-3, 1e4)):  # fmt: skip
            found.append(
                Case("shadows",
                     f"closed {kind} times {power_of_ten(scale)}, {power_of_ten(offset)} away",
                     partial(closed, kind, scale, offset), Dark(),
                     settings=direct, samples=32, noisy=False)
            )  # fmt: skip
    for scale, offset in ((1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1e-3, 0.0), (1.0, 10.0)):
        for thickness in (0.0, 1e-6):
            found.append(
                Case("shadows",
                     f"foot of a wall {power_of_ten(thickness)} aside, times "
                     f"{power_of_ten(scale)}, {power_of_ten(offset)} away",
                     partial(foot, scale, offset, thickness), Dark(),
                     settings={"max_bounces": 0}, samples=32, noisy=False)
            )  # fmt: skip
    bare = {"max_bounces": 0}
    for elevation in (1.0, 0.1, 1e-2, 1e-3, 1e-4):
        for many in (False, True):
            found.append(
                Case("shadows",
                     f"plane of {'many' if many else 'two'} triangles, sun "
                     f"{power_of_ten(elevation)} radians high",
                     partial(sunlit, 0.0, elevation, 1.0, 0.0, many), Truth(lit_by(0.0, elevation)),
                     settings=bare, samples=16)
            )  # fmt: skip
    for scale, offset in ((1e-6, 0.0), (1e6, 0.0), (1.0, 1e2), (1.0, 1e3), (1.0, 1e4)):
        found.append(
            Case("shadows",
                 f"sloping plane times {power_of_ten(scale)}, {power_of_ten(offset)} away",
                 partial(sunlit, 0.37, 0.8, scale, offset, False),
                 Truth(lit_by(0.37, 0.8), 1e-3 if offset <= 1e3 else 5e-3),
                 settings=bare, samples=16)
        )  # fmt: skip
    return found
