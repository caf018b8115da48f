"""The kd-tree finds the nearest points, and all within a radius, at any scale."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from engine_core import probe

Points = NDArray[np.float32]
ROUNDING = 1e-6


def random_points(count: int, scale: float = 1.0, offset: float = 0.0, seed: int = 1) -> Points:
    rng = np.random.default_rng(seed)
    return ((rng.random((count, 3)) + offset) * scale).astype(np.float32)


def assert_nearest(points: Points, queries: Points, k: int, radius: float = 1e15) -> None:
    """Against the plain definition, with room for float32's rounding of distances."""
    tree = probe.KdTree(points)
    indices, distances = tree.nearest(queries, k, radius)
    for query, found, measured in zip(queries, indices, distances, strict=True):
        kept = np.isfinite(measured)
        assert len(set(found[kept])) == kept.sum(), "a point was found twice"
        true = np.sort(np.linalg.norm(points.astype(float) - query.astype(float), axis=1))
        most, least = (
            min(k, int((true <= radius * factor).sum())) for factor in (1 + 1e-6, 1 - 1e-6)
        )
        assert least <= kept.sum() <= most
        expected = true[: kept.sum()]
        assert np.allclose(np.sort(measured[kept]), expected, rtol=ROUNDING, atol=1e-18)
        own = np.linalg.norm(points[found[kept]].astype(float) - query.astype(float), axis=1)
        assert np.allclose(own, measured[kept], rtol=ROUNDING, atol=1e-18)
        if kept.all():
            assert measured[0] == measured.max()


@pytest.mark.parametrize("count", [1, 7, 8, 9, 64, 65, 1000, 4097])
@pytest.mark.parametrize("k", [1, 2, 50])
def test_nearest(count: int, k: int) -> None:
    assert_nearest(random_points(count), random_points(20, 1.4, -0.2, seed=3), k)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("offset", [0.0, 1000.0])
def test_nearest_within_a_radius_at_any_scale(scale: float, offset: float) -> None:
    points = random_points(2000, scale, offset)
    queries = random_points(30, scale, offset, seed=4)
    assert_nearest(points, queries, 20, 0.13 * scale)


@given(st.integers(1, 400), st.integers(1, 60), st.floats(1e-12, 1e12), st.integers(0, 2**31))
@settings(max_examples=60, deadline=None)
def test_any_number_and_scale(count: int, k: int, scale: float, seed: int) -> None:
    points = random_points(count, scale, seed=seed)
    points[::3] = points[0]  # many equal ones
    assert_nearest(points, points[:8], k)


def test_all_within_a_radius_once() -> None:
    points = random_points(5000)
    queries = random_points(60, seed=8)
    counts, found = probe.KdTree(points).within(queries, 0.1)
    reference = cKDTree(points.astype(float))
    ends = np.cumsum(counts)
    for query, own in zip(queries, np.split(found, ends[:-1]), strict=True):
        assert len(set(own)) == len(own)
        inside = reference.query_ball_point(query.astype(float), 0.1 * (1 - ROUNDING))
        edge = reference.query_ball_point(query.astype(float), 0.1 * (1 + ROUNDING))
        assert set(inside) <= set(own) <= set(edge)
    assert counts.sum() > 100


@pytest.mark.parametrize("place", [0.0, 1e-6, -1e6])
def test_all_points_in_one(place: float) -> None:
    points = np.full((30000, 3), place, np.float32)
    tree = probe.KdTree(points)
    indices, distances = tree.nearest(points[:3].copy(), 50, 1.0)
    assert not distances.any()
    assert all(len(set(row)) == 50 for row in indices)
    counts, _ = tree.within(np.array([[place] * 3, [place + 2.0] * 3], np.float32), 1.0)
    assert counts.tolist() == [30000, 0]


def test_no_points() -> None:
    tree = probe.KdTree(np.zeros((0, 3), np.float32))
    _, distances = tree.nearest(np.zeros((1, 3), np.float32), 3, 1.0)
    assert np.all(np.isinf(distances))
    counts, _ = tree.within(np.zeros((1, 3), np.float32), 1.0)
    assert counts[0] == 0


def test_threads_do_not_matter() -> None:
    points = random_points(100_000)
    queries = random_points(100, seed=9)
    first = probe.KdTree(points, 1).nearest(queries, 30, 1.0)
    for threads in (2, 5):
        other = probe.KdTree(points, threads).nearest(queries, 30, 1.0)
        assert np.array_equal(first[0], other[0])
        assert np.array_equal(first[1], other[1])


def test_memory_per_point() -> None:
    for count in (1 << 16, 100_000):
        assert probe.KdTree(random_points(count)).memory <= 18 * count
