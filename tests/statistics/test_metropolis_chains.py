"""Markov chains and their mutations on targets whose distribution is known."""

from __future__ import annotations

import numpy as np
import pytest
from statistics_tools import assert_chi_squared

from engine_core import probe

CELLS = np.array([0.0, 1.0, 3.0, 0.2, 0.0, 10.0, 1e-3, 2.0, 40.0, 0.5, 6.0, 1.0])


@pytest.mark.parametrize("dimensions", [1, 2])
@pytest.mark.parametrize("large_steps", [0.05, 0.3, 1.0])
def test_chains_visit_in_proportion_to_the_target(large_steps: float, dimensions: int) -> None:
    """Thinned, so that visits are as good as independent: the chi-squared test supposes it."""
    every = 200
    chance, expected = (
        np.array(v) for v in probe.toy_chain(CELLS, 4_000_000, large_steps, dimensions, 7, every)
    )
    truth = CELLS / CELLS.sum()
    assert_chi_squared(chance, truth * chance.sum())
    # Expected values count what is proposed too: the same visits, and less noise.
    assert expected.sum() == pytest.approx(4_000_000, rel=1e-9)
    assert abs(expected / expected.sum() - truth).max() < 0.02


def test_a_part_s_points_are_in_it_however_they_are_rounded() -> None:
    """A chain starts at the technique that was chosen for it, and at no neighbour."""
    ends = [0.0, *(2.0**-k for k in range(1, 25)), *(1.0 - 2.0**-k for k in range(1, 25))]
    for count in (1, 2, 3, 5, 6, 7, 12, 20, 33):
        for part in range(count):
            for within in ends:
                u = probe.point_of_part(part, count, within)
                assert 0.0 <= u < 1.0
                assert probe.part_of(u, count) == part
                assert u == pytest.approx((part + within) / count, abs=2e-7)


def test_a_start_is_never_one_without_light(rng: np.random.Generator) -> None:
    targets = rng.uniform(0, 1, 50) * (rng.uniform(0, 1, 50) < 0.5)
    targets[[0, -1]] = 0.0
    sums = list(np.cumsum(targets))
    points = [0.0, *rng.uniform(0, 1, 1000), 1.0 - 2.0**-53, 1.0, *(np.array(sums) / sums[-1])]
    chosen = np.array([probe.choose_by_sums(sums, u) for u in points])
    assert (targets[chosen] > 0.0).all()
    assert set(chosen) == set(np.flatnonzero(targets))


def test_small_steps_are_symmetric_and_stay_inside(rng: np.random.Generator) -> None:
    u = rng.random(400_000, np.float32)
    u[:4] = (0.0, np.nextafter(np.float32(1), np.float32(0)), 1e-30, 0.5)
    moved = np.array(probe.small_steps(u, rng.integers(0, 2**32, u.size, dtype=np.uint32)))
    assert (moved >= 0).all()
    assert (moved < 1).all()
    # Uniform numbers stay uniform, and as many pairs go from one cell to another as come back.
    cells = 32
    pairs = np.zeros((cells, cells))
    np.add.at(pairs, ((u * cells).astype(int), (moved * cells).astype(int)), 1)
    assert_chi_squared(pairs.sum(axis=0), np.full(cells, u.size / cells))
    both = (pairs + pairs.T) / 2
    upper = np.triu_indices(cells, 1)
    assert_chi_squared(pairs[upper], both[upper])
    distance = abs(moved.astype(float) - u)
    distance = np.minimum(distance, 1 - distance)
    # From 1/1024 to 1/16 each octave as often, but for 256 being no multiple of 6; rounding of u
    # moves distances from one to the next.
    counts = np.histogram(np.log2(distance[4:]), np.arange(-10, -3))[0]
    assert counts.sum() > 0.999 * (u.size - 4)
    assert abs(counts / counts.mean() - 1).max() < 6 / 256 + 5 / np.sqrt(counts.mean())


@pytest.mark.parametrize(
    ("current", "proposed", "ratio", "expected"),
    [
        (1.0, 2.0, 1.0, 1.0),
        (2.0, 1.0, 1.0, 0.5),
        (2.0, 1.0, 4.0, 1.0),
        (1.0, 0.0, 1.0, 0.0),
        (1.0, 1.0, 0.0, 0.0),
        (1e-300, 1e300, 1.0, 1.0),
        (1e300, 1e-300, 1.0, 0.0),
        (1.0, 1.0, float("nan"), 0.0),
    ],
)
def test_acceptance(current: float, proposed: float, ratio: float, expected: float) -> None:
    assert probe.acceptance(current, proposed, ratio) == expected
