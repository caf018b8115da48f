"""The hash grid finds every point within its radius exactly once, at any scale."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from engine_core import probe

Points = NDArray[np.float32]


def visited(grid: probe.HashGrid, queries: Points) -> list[NDArray[np.uint32]]:
    counts, found = grid.visit(queries)
    return np.split(found, np.cumsum(counts)[:-1])


def assert_finds_all_once(points: Points, radius: float, queries: Points) -> int:
    """Against the plain definition, with room for float32's rounding at the very edge.

    Returns how many points were found.
    """
    grid = probe.HashGrid(points, radius)
    total = 0
    for query, found in zip(queries, visited(grid, queries), strict=True):
        assert len(set(found)) == len(found), "a point was visited twice"
        distances = np.linalg.norm(points.astype(float) - query.astype(float), axis=1)
        inside = np.flatnonzero(distances < radius * (1 - 1e-6))
        edge = np.flatnonzero(distances <= radius * (1 + 1e-6))
        assert set(inside) <= set(found) <= set(edge)
        total += len(found)
    return total


def random_points(count: int, scale: float = 1.0, offset: float = 0.0, seed: int = 1) -> Points:
    rng = np.random.default_rng(seed)
    return ((rng.random((count, 3)) + offset) * scale).astype(np.float32)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("offset", [0.0, -0.5, 100.0])
def test_finds_all_points_once(scale: float, offset: float) -> None:
    points = random_points(3000, scale, offset)
    queries = random_points(60, scale, offset, seed=2)
    assert assert_finds_all_once(points, 0.15 * scale, queries) > 60


def test_points_on_the_edges_of_cells() -> None:
    """A lattice as wide as the radius: points lie exactly at the radius and on cells' walls."""
    axis = np.arange(-6, 7, dtype=np.float32)
    points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    assert assert_finds_all_once(points, 1.0, points[::7].copy()) > 0
    counts, _ = probe.HashGrid(points, 1.0).visit(np.zeros((1, 3), np.float32))
    assert counts[0] == 7  # those at the radius are within it


def test_radius_below_what_positions_can_tell() -> None:
    """A million units away positions are 1/16 apart: the grid is no finer than that."""
    points = random_points(2000, 1.0, 1e6)
    assert assert_finds_all_once(points, 1e-6, points[:50].copy()) >= 50


def test_radius_beyond_the_scene() -> None:
    points = random_points(500)
    counts, _ = probe.HashGrid(points, 100.0).visit(random_points(5, seed=3))
    assert np.all(counts == 500)


def test_radius_of_zero_finds_equal_points() -> None:
    points = np.repeat(random_points(200), 3, axis=0)
    counts, _ = probe.HashGrid(points, 0.0).visit(points[::3].copy())
    assert np.all(counts == 3)


@pytest.mark.parametrize("place", [0.0, 1e-6, -1e6])
def test_all_points_in_one(place: float) -> None:
    points = np.full((40000, 3), place, np.float32)
    grid = probe.HashGrid(points, 1e-3)
    counts, found = grid.visit(np.array([[place] * 3, [place + 1.0] * 3], np.float32))
    assert counts.tolist() == [40000, 0]
    assert np.array_equal(found, np.arange(40000))


def test_no_points_and_one() -> None:
    query = np.zeros((1, 3), np.float32)
    counts, _ = probe.HashGrid(np.zeros((0, 3), np.float32), 1.0).visit(query)
    assert counts[0] == 0
    counts, _ = probe.HashGrid(query, 1.0).visit(query)
    assert counts[0] == 1


def test_queries_far_outside() -> None:
    grid = probe.HashGrid(random_points(100), 0.1)
    far = np.array([[1e30, 0, 0], [-1e30, 0, 0], [0.5, 0.5, 3e38]], np.float32)
    counts, _ = grid.visit(far)
    assert not counts.any()


def test_collisions_count_once() -> None:
    """Few buckets for many cells: each query's cells share buckets, and each point is met once."""
    rng = np.random.default_rng(5)
    for count in range(1, 40):
        points = rng.random((count, 3)).astype(np.float32)
        assert_finds_all_once(points, 0.05, points)


def test_threads_do_not_matter() -> None:
    points = random_points(100_000)
    queries = random_points(200, seed=9)
    first = probe.HashGrid(points, 0.03, 1).visit(queries)
    for threads in (2, 5):
        other = probe.HashGrid(points, 0.03, threads).visit(queries)
        assert np.array_equal(first[0], other[0])
        assert np.array_equal(first[1], other[1])


def test_memory_per_point() -> None:
    points = random_points(1 << 16)
    assert probe.HashGrid(points, 0.01).memory <= 24 * len(points) + 64


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 200),
    st.floats(1e-12, 1e12),
    st.floats(1e-6, 10.0),
    st.floats(-1e6, 1e6),
    st.integers(0, 2**31),
)
def test_any_scale_place_and_radius(
    count: int, scale: float, radius: float, offset: float, seed: int
) -> None:
    points = random_points(count, scale, offset, seed)
    radius *= scale
    queries = random_points(8, scale, offset, seed + 1)
    assert_finds_all_once(points, radius, np.concatenate([queries, points[:8]]))
