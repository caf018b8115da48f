"""Caustics seen through glass: paths that only a BSDF's chance or the guide of photons makes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from bidirectional_scenes import MATERIALS, checkered, clear, constant_mix, glass
from scenes import Array, SceneBuilder, background, emission, pictures, quad, sphere
from statistics_tools import assert_chi_squared, assert_equal_means

import engine_core
from engine_core import probe

METHODS = ["PSSMLT", "MMLT", "MLT"]
SEEDS = 8


def pool(sun_angle: float = 0.3) -> SceneBuilder:
    """A floor under a pane of glass and a ball in it, which the sun and a dim sky light."""
    scene = SceneBuilder((12, 12))
    scene.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), checkered())
    scene.add(quad((-3, -3, 1.0), (6, 0, 0), (0, 6, 0)), MATERIALS["glass"])
    scene.add(sphere(0.4, (0.5, 0.2, 0.45), rings=6), MATERIALS["glass"])
    scene.light("SUN", emission=(4.0, 3.5, 3.0), sun_angle=sun_angle)
    scene.description.world = background(0.1)
    scene.camera((0.3, -4.0, 3.5), (0, 0, 0.2), fov=30)
    return scene


def panel() -> SceneBuilder:
    """The same under a lamp that is a mesh."""
    scene = pool()
    scene.description.lights.clear()
    scene.add(quad((-0.6, -0.6, 2.5), (0, 1.2, 0), (1.2, 0, 0)), emission(5.0))
    return scene


def half_clear() -> SceneBuilder:
    """Sheets in the water that let light straight through, in part: paths pass and go on."""
    scene = pool()
    scene.add(quad((-2, -2, 0.5), (4, 0, 0), (0, 3, 0)), MATERIALS["half_clear"])
    scene.add(
        quad((-2, -2, 0.7), (4, 0, 0), (0, 3, 0)), constant_mix(0.5, clear(0.8), glass(0.0, 1.2))
    )
    return scene


SCENES: dict[str, Callable[[], SceneBuilder]] = {
    "pool": pool,
    "panel": panel,
    "half_clear": half_clear,
}


@pytest.mark.parametrize("name", SCENES)
def test_pictures(name: str) -> None:
    builder = SCENES[name]()
    path = pictures(builder, SEEDS, samples=512, max_bounces=6)
    for method in METHODS:
        made = pictures(builder, SEEDS, integrator=method, samples=48, max_bounces=6)
        assert_equal_means(path, made, block=6)


@pytest.mark.parametrize("method", METHODS)
def test_no_start_up_bias(method: str) -> None:
    """Chains of a few mutations, from seeds that the guide has found."""
    path = pictures(pool(), SEEDS, samples=512, max_bounces=4)
    short = pictures(pool(), 32, integrator=method, samples=1, max_bounces=4, chain_length=4)
    assert_equal_means(path, short, block=6)


def test_small_lights_are_found() -> None:
    """A sun that BSDFs meet once in ten thousand times, so that other methods do not see it."""
    scene = pool(sun_angle=0.01)

    def means(integrator: str) -> Array:
        made = pictures(scene, 6, integrator=integrator, samples=16, max_bounces=4)
        return np.array(made.mean(axis=(1, 2, 3)))

    without = means("BDPT").mean()
    for method in METHODS:
        found = means(method)
        assert found.std(ddof=1) < 0.6 * found.mean()
        assert found.mean() > 3 * without


@pytest.mark.parametrize("method", METHODS)
def test_chains_do_not_stick(method: str) -> None:
    """A start that only rare chance finds weighs so much that nothing near it is accepted."""
    scene = engine_core.compile(pool(sun_angle=0.005).description, threads=1)

    def longest_rejections(**settings: Any) -> Array:
        settings = {"integrator": method, "threads": 1, "max_bounces": 6, **settings}
        return np.array(probe.rejection_runs(scene, settings, 300, 256, 3), np.float64)

    assert np.quantile(longest_rejections(), 0.95) < 160
    if method != "MLT":
        # Limits by kind leave such paths to chance. (Changes of paths themselves go on from there.)
        assert np.median(longest_rejections(diffuse_bounces=100)) == 256


@pytest.mark.parametrize("count", [1, 2, 24])
def test_guided_directions(count: int, rng: np.random.Generator) -> None:
    """They fall as their density says, which integrates to one."""
    axes = rng.normal((0.3, 0.1, 1.0), 0.2, (count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    axes, weights = axes.astype(np.float32), list(rng.uniform(0.5, 2.0, count))
    drawn = np.array(probe.lobe_directions(axes, weights, rng.random((100_000, 3), np.float32)))
    assert abs(np.linalg.norm(drawn, axis=1) - 1).max() < 1e-5
    rows, columns, fine = 40, 20, 24
    z = (np.arange(rows * fine) + 0.5) / (rows * fine) * 2 - 1
    phi = (np.arange(columns * fine) + 0.5) / (columns * fine) * 2 * np.pi
    r = np.sqrt(1 - z**2)[:, None]
    grid = np.stack(np.broadcast_arrays(r * np.cos(phi), r * np.sin(phi), z[:, None]), axis=-1)
    directions = np.ascontiguousarray(grid.reshape(-1, 3), np.float32)
    pdf = np.array(probe.lobe_density(axes, weights, directions)).reshape(grid.shape[:2])
    expected = pdf.reshape(rows, fine, columns, fine).mean(axis=(1, 3)) * 4 * np.pi
    expected /= rows * columns
    assert expected.sum() == pytest.approx(1.0, abs=2e-3)
    turn = np.arctan2(drawn[:, 1], drawn[:, 0]) % (2 * np.pi)
    observed = np.histogram2d(
        drawn[:, 2], turn, (rows, columns), ((-1, 1), (0, 2 * np.pi))
    )[0]  # fmt: skip
    # The narrow peak of a lone lobe is finer than the grid: cells are no better than this.
    assert_chi_squared(observed, expected * (len(drawn) / expected.sum()))
