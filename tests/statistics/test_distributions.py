"""Tabulated distributions and the map of the environment."""

from __future__ import annotations

import numpy as np
import pytest
from light_probes import uniforms, unit
from statistics_tools import assert_chi_squared

from engine_core import probe

NONE = np.zeros((0, 3), np.float32)


def test_grid_samples_follow_their_weights(rng: np.random.Generator) -> None:
    weights = rng.lognormal(0, 1.5, (9, 13)).astype(np.float32)
    weights[3] = 0
    weights[:, 5] = 0
    n = 50_000
    s = np.asarray(probe.sample_grid(weights, uniforms(rng, n, 2)), np.float64)
    cells = np.histogram2d(s[:, 1], s[:, 0], bins=(9, 13), range=[[0, 1], [0, 1]])[0]
    expected = n * weights / weights.sum(dtype=np.float64)
    assert (cells[weights == 0] == 0).all()
    assert_chi_squared(cells[weights > 0], expected[weights > 0])
    at = np.ascontiguousarray(s[:, :2], np.float32)
    assert probe.grid_pdf(weights, at)[:, 0] == pytest.approx(s[:, 2], rel=1e-5)
    y, x = (np.arange(9) + 0.5) / 9, (np.arange(13) + 0.5) / 13
    centres = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2).astype(np.float32)
    pdf = np.asarray(probe.grid_pdf(weights, centres), np.float64)[:, 0]
    assert pdf.mean() == pytest.approx(1, rel=1e-5)
    assert pdf.reshape(9, 13) == pytest.approx(expected / n * 9 * 13, rel=1e-4)


def test_one_pixel_of_a_billion(rng: np.random.Generator) -> None:
    weights = np.ones((64, 64), np.float32)
    weights[10, 20] = 1e9
    s = probe.sample_grid(weights, uniforms(rng, 20_000, 2))
    inside = (np.floor(s[:, 0] * 64) == 20) & (np.floor(s[:, 1] * 64) == 10)
    assert inside.mean() > 0.999
    assert np.isfinite(s).all()
    assert (s[:, 2] > 0).all()
    assert s[inside, 2] == pytest.approx(64 * 64, rel=1e-4)


@pytest.mark.parametrize("value", [0.0, 1e-30, 1e30])
def test_flat_grids_are_uniform(value: float, rng: np.random.Generator) -> None:
    s = probe.sample_grid(np.full((4, 8), value, np.float32), uniforms(rng, 1000, 2))
    assert s[:, 2] == pytest.approx(1, rel=1e-5)


def test_alias_table(rng: np.random.Generator) -> None:
    weights = rng.lognormal(0, 2, (1, 300)).astype(np.float32)
    weights[0, ::7] = 0
    n = 100_000
    s = np.asarray(probe.sample_alias(weights, uniforms(rng, n, 1)), np.float64)
    chance = weights[0].astype(np.float64) / weights.sum(dtype=np.float64)
    item = s[:, 0].astype(int)
    assert s[:, 1] == pytest.approx(chance[item], rel=1e-5)
    counts = np.bincount(item, minlength=300)
    assert (counts[::7] == 0).all()
    assert_chi_squared(counts[chance > 0].astype(float), n * chance[chance > 0])


def test_octahedral_map_preserves_area_and_inverts(rng: np.random.Generator) -> None:
    n = 60_000
    points = uniforms(rng, n, 2)
    table = np.asarray(probe.octahedral_map(points), np.float64)
    assert np.linalg.norm(table[:, :3], axis=1) == pytest.approx(1, abs=1e-6)
    assert table[:, 3:] == pytest.approx(points, abs=1e-5)
    z, phi = table[:, 2], np.arctan2(table[:, 1], table[:, 0])
    cells = np.histogram2d(z, phi, bins=(12, 12), range=[[-1, 1], [-np.pi, np.pi]])[0]
    assert_chi_squared(cells, np.full((12, 12), n / 144))


def test_environment_samples_follow_the_map(rng: np.random.Generator) -> None:
    axis = unit([0.3, -0.5, 0.8])
    lobes = np.array([[*axis, 30.0, 10.0], [0, 0, -1, 0, 0.5]], np.float32)
    n = 40_000
    s = np.asarray(probe.environment_map(128, lobes, uniforms(rng, n, 2), NONE), np.float64)
    d, pdf = s[:, :3], s[:, 3]
    again = probe.environment_map(128, lobes, np.zeros((0, 2), np.float32), d.astype(np.float32))[
        :, 3
    ]
    # Directions on a cell's rim may round into its neighbour.
    assert (abs(again / pdf - 1) < 1e-4).mean() > 0.99
    total = 4 * np.pi * 0.5 + 10 * 2 * np.pi * (1 - np.exp(-60)) / 30
    radiance = 10 * np.exp(30 * (d @ axis - 1)) + 0.5
    assert np.median(pdf * total / radiance) == pytest.approx(1, rel=0.01)
    # Cells of equal solid angle about the lobe.
    z = d @ axis
    edges = np.array([-1, -0.5, 0, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 1.0])
    integral = np.diff(10 * 2 * np.pi / 30 * np.exp(30 * (edges - 1)) + np.pi * edges)
    observed = np.histogram(z, bins=edges)[0]
    # The map's cells are half a degree: their steps shift the edges' counts by less than noise.
    assert_chi_squared(observed.astype(float), n * integral / total)
