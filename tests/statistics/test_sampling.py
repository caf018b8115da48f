"""The sampler's points, the pixel filter and the camera, against their densities."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import SceneBuilder
from scipy import stats
from statistics_tools import SIGNIFICANCE, assert_chi_squared

import engine_core
from engine_core import probe


@pytest.mark.parametrize("dimension", [0, 1, 5, 37])
def test_points_of_a_pixel_are_stratified(dimension: int) -> None:
    """64 points of one pixel fill every elementary interval of area 1/64 once: a (0,6,2)-net."""
    points = probe.sobol_points(3, 3, 64, 7, dimension).reshape(9, 64, 2)
    for pixel in points:
        for k in range(7):
            a, b = 2**k, 2 ** (6 - k)
            cells = np.floor(pixel * [a, b]).astype(int)
            assert len({tuple(c) for c in cells}) == 64


def test_neighbouring_pixels_share_a_net() -> None:
    """The 4 points of a 2x2 block at one sample per pixel are a net as well: blue noise."""
    points = probe.sobol_points(8, 8, 1, 11, 3).reshape(8, 8, 2)
    for y in range(0, 8, 2):
        for x in range(0, 8, 2):
            block = points[y : y + 2, x : x + 2].reshape(4, 2)
            for k in range(3):
                cells = np.floor(block * [2**k, 2 ** (2 - k)]).astype(int)
                assert len({tuple(c) for c in cells}) == 4


def test_error_is_pushed_to_high_frequencies() -> None:
    """Errors of single samples: averages over 2x2 blocks are far better than for white noise."""
    points = probe.sobol_points(64, 64, 1, 3, 2)[:, 0].reshape(64, 64)
    blocks = points.reshape(32, 2, 32, 2).mean(axis=(1, 3))
    assert blocks.var() < 0.25 * points.var() / 4


def test_batches_are_independent() -> None:
    a = probe.sobol_points(32, 32, 1, 1, 4).ravel()
    b = probe.sobol_points(32, 32, 1, 2, 4).ravel()
    correlation = stats.pearsonr(a, b)
    assert correlation.pvalue > SIGNIFICANCE


def test_dimensions_are_independent() -> None:
    a = probe.sobol_points(32, 32, 4, 1, 4)[:, 0]
    b = probe.sobol_points(32, 32, 4, 1, 5)[:, 0]
    grid = np.histogram2d(a, b, bins=8, range=[[0, 1], [0, 1]])[0]
    # A net's points are more even than random ones: only excess may alarm.
    statistic = ((grid - a.size / 64) ** 2 / (a.size / 64)).sum()
    assert stats.chi2.sf(statistic, 63) > SIGNIFICANCE


@pytest.mark.parametrize(
    ("kind", "shape"),
    [
        ("BOX", lambda x: np.ones_like(x)),
        ("GAUSSIAN", lambda x: np.exp(-2 * (6 * x) ** 2)),
        (
            "BLACKMAN_HARRIS",
            lambda x: (
                0.35875
                - 0.48829 * np.cos(2 * np.pi * (x + 0.5))
                + 0.14128 * np.cos(4 * np.pi * (x + 0.5))
                - 0.01168 * np.cos(6 * np.pi * (x + 0.5))
            ),
        ),
    ],
)
def test_pixel_filter(kind: str, shape, rng: np.random.Generator) -> None:  # type: ignore[no-untyped-def]
    width, count = 1.5, 100_000
    extent = width * {"BOX": 1, "GAUSSIAN": 3, "BLACKMAN_HARRIS": 2}[kind]
    u = rng.random((count, 2), np.float32)
    offsets = probe.filter_offsets(kind, width, u)
    edges = np.linspace(-0.5, 0.5, 41)
    fine = (np.arange(40 * 64) + 0.5) / (40 * 64) - 0.5
    mass = shape(fine).reshape(40, 64).sum(axis=1)
    for axis in range(2):
        observed = np.histogram(offsets[:, axis] / extent, edges)[0].astype(float)
        assert_chi_squared(observed, mass / mass.sum() * count)


CAMERAS = {
    "pinhole": {},
    "thin lens": {"aperture_radius": 0.3, "focus_distance": 2.0},
    "blades": {"aperture_radius": 0.3, "focus_distance": 2.0, "blades": 5, "blade_rotation": 0.4},
    "anamorphic": {"aperture_radius": 0.2, "focus_distance": 3.0, "aperture_ratio": 2.0},
    "orthographic": {"kind": "ORTHOGRAPHIC"},
    "orthographic lens": {
        "kind": "ORTHOGRAPHIC", "aperture_radius": 0.2, "focus_distance": 2.0},
}  # fmt: skip


def camera_scene(name: str) -> engine_core.Scene:
    scene = SceneBuilder((40, 30))
    scene.camera((1, 2, 3), (0, 0.5, 0), fov=60, **CAMERAS[name])
    return engine_core.compile(scene.description)


@pytest.mark.parametrize("name", [n for n in CAMERAS if n != "orthographic"])
def test_camera_directions_follow_their_density(name: str, rng: np.random.Generator) -> None:
    """Rays of uniform raster positions: 1/(pdf_area pdf_direction) integrates to the measure.

    The mean of g / (pdf_area pdf_direction) over sampled rays equals the integral of g over lens
    area and solid angle; with g = cos We it is the number of pixels.
    """
    scene = camera_scene(name)
    count = 40_000
    raster = (rng.random((count, 2)) * [40, 30]).astype(np.float32)
    rows = probe.camera_rays(scene, raster, rng.random((count, 2), np.float32)).astype(float)
    cosine, pdf_area, pdf_direction, importance = rows[:, 6:10].T
    value = cosine * importance / (pdf_area * pdf_direction)
    # Exactly constant: importance is proportional to the density.
    assert value == pytest.approx(40 * 30, rel=1e-4)
    lens = rows[:, :3]
    assert abs(lens[:, 2]).max() < 1e-5
    # The density of directions, as a histogram over the window, against pdf_direction.
    if name in ("pinhole", "thin lens"):
        directions = rows[:, 3:6] / rows[:, 5:6] * -1
        if name == "pinhole":
            half = np.tan(np.radians(30))
            observed = np.histogram2d(
                directions[:, 0], directions[:, 1], bins=[8, 6],
                range=[[-half, half], [-half * 0.75, half * 0.75]],
            )[0]  # fmt: skip
            assert observed.sum() == count
            assert_chi_squared(observed, np.full((8, 6), count / 48))


@pytest.mark.parametrize("name", CAMERAS)
def test_connections_agree_with_rays(name: str, rng: np.random.Generator) -> None:
    """A point on a camera ray, connected to that ray's lens point, lands on the ray's raster.

    Lens points of connections are drawn anew, so the ray of the connection is traced back: the
    point must lie on it, and importance times density must be We.
    """
    scene = camera_scene(name)
    count = 2000
    u = rng.random((count, 2), np.float32)
    raster = (rng.random((count, 2)) * [40, 30]).astype(np.float32)
    rays = probe.camera_rays(scene, raster, u).astype(float)
    distance = rng.uniform(0.5, 6.0, (count, 1))
    points = (rays[:, :3] + distance * rays[:, 3:6]).astype(np.float32)
    rows = probe.camera_connections(scene, points, u).astype(float)
    found = rows[:, 0] > 0
    assert found.mean() > 0.3
    back = probe.camera_rays(scene, rows[found, 4:6].astype(np.float32), u[found]).astype(float)
    assert back[:, :3] == pytest.approx(rows[found, 1:4], abs=2e-4)
    toward = points[found] - back[:, :3]
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    assert toward == pytest.approx(back[:, 3:6], abs=5e-4)
    if name != "orthographic":
        pinhole = name == "pinhole"
        solid = back[:, 6] / rows[found, 6] ** 2 if pinhole else 1.0
        assert rows[found, 7] * rows[found, 8] == pytest.approx(back[:, 9] * solid, rel=2e-3)


@pytest.mark.parametrize("fov", [1.0, 60.0, 170.0, 179.9])
def test_footprints_are_of_the_pixels_solid_angle(fov: float, rng: np.random.Generator) -> None:
    """Half as wide as the pixel appears, and never wider than its distance."""
    scene = SceneBuilder((40, 30))
    scene.camera((1, 2, 3), (0, 0.5, 0), fov=fov)
    compiled = engine_core.compile(scene.description)
    raster = (rng.random((500, 2)) * [40, 30]).astype(np.float32)
    rays = probe.camera_rays(compiled, raster, rng.random((500, 2), np.float32)).astype(float)
    solid_angle = 1 / (rays[:, 8] * 40 * 30)
    distance = 10.0 ** rng.uniform(-3, 3, 500)
    points = (distance[:, None] * rays[:, 3:6]).astype(np.float32)
    found = probe.camera_footprints(compiled, points)[:, 0]
    slope = np.sqrt(solid_angle) / 2
    assert found / distance == pytest.approx(slope / np.hypot(1, slope), rel=2e-3)
    # Behind, and beside the picture: what the pixels in its corner are.
    corner = probe.camera_rays(compiled, np.zeros((1, 2), np.float32), np.zeros((1, 2), np.float32))
    slope = np.sqrt(1 / (float(corner[0, 8]) * 40 * 30)) / 2
    outside = np.array([[0, 0, 5], [3, 0, 4], [0, -5, 1e-6], [0, 0, 0]], np.float32)
    expected = [5 * slope / np.hypot(1, slope)] * 3 + [0]
    assert probe.camera_footprints(compiled, outside)[:, 0] == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("name", ["thin lens", "blades", "orthographic lens"])
def test_connection_density(name: str, rng: np.random.Generator) -> None:
    """Densities of lens points, per solid angle at the point, integrate to 1 over the lens."""
    scene = camera_scene(name)
    count = 20_000
    point = np.tile(np.array([[0.05, -0.03, -2.4]], np.float32), (count, 1))
    rows = probe.camera_connections(scene, point, rng.random((count, 2), np.float32)).astype(float)
    assert (rows[:, 0] > 0).all()
    # E[1 / pdf] is the solid angle of the lens seen from the point, here by its area.
    toward = rows[:, 1:4] - point
    distance = np.linalg.norm(toward, axis=1)
    cosine = toward[:, 2] / distance
    area = (distance**2 / cosine / rows[:, 8]).mean()
    shape = {"thin lens": np.pi * 0.09, "blades": 2.5 * np.sin(2 * np.pi / 5) * 0.09}
    expected = shape.get(name, np.pi * 0.04 * (2.4 / 2.0) ** 2)
    assert area == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("name", CAMERAS)
def test_the_density_across_rays(name: str, rng: np.random.Generator) -> None:
    """Rays of one lens point, where they cross a plane aslant: pdf_across times its cosine."""
    scene = camera_scene(name)
    count, cells, fine = 200_000, (16, 12), 32
    normal = np.array([0.4, -0.3, 1.0]) / np.sqrt(1.25)
    right = np.cross([0.0, 1.0, 0.0], normal) / np.hypot(normal[0], normal[2])
    up = np.cross(normal, right)
    middle = np.array([0.0, 0.0, -3.0])
    u = np.array([[0.3, 0.8]], np.float32)
    raster = (rng.random((count, 2)) * [40, 30]).astype(np.float32)
    rays = probe.camera_rays(scene, raster, np.repeat(u, count, 0)).astype(float)
    along = ((middle - rays[:, :3]) @ normal) / (rays[:, 3:6] @ normal)
    crossing = rays[:, :3] + along[:, None] * rays[:, 3:6] - middle
    x, y = crossing @ right, crossing @ up
    edges = [np.linspace(v.min(), v.max(), n + 1) for v, n in zip((x, y), cells, strict=True)]
    observed = np.histogram2d(x, y, bins=edges)[0]

    a, b = (
        e[0] + (e[-1] - e[0]) * (np.arange(n * fine) + 0.5) / (n * fine)
        for e, n in zip(edges, cells, strict=True)
    )
    points = middle + a[:, None, None] * right + b[None, :, None] * up
    flat = points.reshape(-1, 3).astype(np.float32)
    rows = probe.camera_connections(scene, flat, np.repeat(u, len(flat), 0)).astype(float)
    aslant = abs((flat - rows[:, 1:4]) @ normal) / np.where(rows[:, 0] > 0, rows[:, 6], 1.0)
    density = np.where(rows[:, 0] > 0, rows[:, 9] * aslant, 0.0)
    mass = density.reshape(cells[0], fine, cells[1], fine).sum(axis=(1, 3))
    mass *= (a[1] - a[0]) * (b[1] - b[0])
    assert mass.sum() == pytest.approx(1.0, rel=2e-3)
    assert_chi_squared(observed, mass / mass.sum() * count)
