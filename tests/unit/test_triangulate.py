"""Polygons of every kind become n - 2 triangles that cover them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from engine_core import probe

Array = NDArray[np.float64]

ARROW = [(0, 0), (4, 0), (2, 1), (4, 4), (0, 4)]
COMB = [(0, 0), (9, 0), (9, 3), (8, 1), (6, 3), (5, 1), (3, 3), (2, 1), (0, 3)]
SPIRAL = [(0, 0), (7, 0), (7, 7), (1, 7), (1, 2), (5, 2), (5, 5), (4, 5), (4, 3), (2, 3), (2, 6),
          (6, 6), (6, 1), (0, 1)]  # fmt: skip
SIMPLE = {
    "square": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "dart whose diagonal 0-2 lies outside": [(0, 0), (2, 2), (0, 1), (-2, 2)],
    "dart whose diagonal 1-3 lies outside": [(0, 0), (2, -2), (0, 3), (-2, -2)],
    "regular pentagon": [
        (np.cos(a), np.sin(a)) for a in np.linspace(0, 2 * np.pi, 5, endpoint=False)
    ],
    "arrow": ARROW,
    "comb": COMB,
    "spiral": SPIRAL,
    "corners on a straight side": [(0, 0), (1, 0), (2, 0), (3, 0), (3, 2), (2, 2), (0, 2)],
    "many corners": [
        ((2 + np.cos(7 * a)) * np.cos(a), (2 + np.cos(7 * a)) * np.sin(a))
        for a in np.linspace(0, 2 * np.pi, 211, endpoint=False)
    ],
}
DEGENERATE = {
    "bow tie": [(0, 0), (1, 1), (1, 0), (0, 1)],
    "pentagram": [
        (np.cos(a), np.sin(a)) for a in 4 * np.pi / 5 * np.arange(5)
    ],
    "all on a line": [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 0)],
    "all in one place": [(1, 1)] * 7,
    "there and back": [(0, 0), (1, 0), (2, 0), (1, 0), (0, 0), (-1, 0)],
    "a corner twice": [(0, 0), (1, 0), (1, 0), (1, 1), (0, 1)],
    "huge": [(0, 0), (1e38, 0), (1e38, 1e38), (4e37, 6e37), (0, 1e38)],
    "tiny": [(0, 0), (1e-38, 0), (1e-38, 1e-38), (5e-39, 5e-39), (0, 1e-38)],
}  # fmt: skip


def cut(polygon: Array) -> NDArray[np.int64]:
    return np.array(probe.triangulate(np.ascontiguousarray(polygon, np.float32)), np.int64)


def placed(points: list[tuple[float, float]], plane: int, flipped: bool) -> Array:
    """The polygon in a plane of space: an axis plane, or a tilted one."""
    flat = np.array(points, np.float64)
    if flipped:
        flat = flat[::-1]
    solid = np.insert(flat, 2, 0.0, axis=1)
    if plane < 3:
        return np.roll(solid, plane, axis=1)
    turn, _ = np.linalg.qr(np.array([(1.0, 2, 3), (-2, 1, 0.5), (0.3, -1, 2)]))
    return np.array(solid @ turn + (5.0, -3.0, 2.0))


def area_vectors(polygon: Array, triangles: NDArray[np.int64]) -> Array:
    a, b, c = (polygon[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2


def polygon_area_vector(polygon: Array) -> Array:
    p = polygon - polygon[0]
    return np.array(np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0) / 2)


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("plane", range(4))
@pytest.mark.parametrize("name", SIMPLE)
def test_a_simple_polygon_is_covered_once(name: str, plane: int, flipped: bool) -> None:
    polygon = placed(SIMPLE[name], plane, flipped)
    triangles = cut(polygon)
    assert triangles.shape == (len(polygon) - 2, 3)
    total = polygon_area_vector(polygon)
    area = np.linalg.norm(total)
    pieces = area_vectors(polygon, triangles) @ (total / area)
    # No piece is turned over, and together they have the polygon's area: nothing is covered twice
    # and nothing left out. The corners were rounded to float32.
    rounding = 1e-5 * area
    assert pieces.min() > -rounding
    assert abs(pieces.sum() - area) < rounding


@pytest.mark.parametrize("polygons", [SIMPLE, DEGENERATE], ids=["simple", "degenerate"])
def test_every_polygon_gives_two_triangles_fewer_than_it_has_corners(
    polygons: dict[str, list[tuple[float, float]]],
) -> None:
    for name, points in polygons.items():
        for plane in range(4):
            triangles = cut(placed(points, plane, False))
            assert triangles.shape == (len(points) - 2, 3), name
            assert triangles.min() >= 0, name
            assert triangles.max() < len(points), name
            # Three different corners each, and none is left out.
            assert all(len(set(t)) == 3 for t in triangles.tolist()), name
            assert set(triangles.ravel().tolist()) == set(range(len(points))), name


@pytest.mark.parametrize("name", ["bow tie", "pentagram", "a corner twice", "there and back"])
def test_signed_areas_add_up_where_a_polygon_crosses_itself(name: str) -> None:
    polygon = placed(DEGENERATE[name], 3, False)
    total = area_vectors(polygon, cut(polygon)).sum(axis=0)
    assert np.allclose(total, polygon_area_vector(polygon), atol=1e-5)


def test_a_convex_quadrilateral_is_cut_from_its_first_corner() -> None:
    square = placed(SIMPLE["square"], 2, False)
    assert cut(square).tolist() == [[0, 1, 2], [0, 2, 3]]


def test_a_bent_quadrilateral_is_cut_into_two_that_face_one_way() -> None:
    bent = np.array([(0, 0, 0), (1, 0, 0.3), (1, 1, 0), (0, 1, 0.3)], np.float64)
    normals = area_vectors(bent, cut(bent))
    assert normals[0] @ normals[1] > 0


def test_triangles_stay_and_less_gives_nothing() -> None:
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], np.float64)
    assert cut(points).tolist() == [[0, 1, 2]]
    assert cut(points[:2]).size == 0
    assert len(probe.triangulate(np.zeros((0, 3), np.float32))) == 0


def test_random_stars_are_covered_once(rng: np.random.Generator) -> None:
    for corners in rng.integers(5, 60, 50):
        angles = np.sort(rng.uniform(0, 2 * np.pi, corners))
        if np.diff(angles, append=angles[0] + 2 * np.pi).max() >= np.pi:
            continue  # the centre is outside: no star
        radii = rng.uniform(0.3, 1.0, corners)
        polygon = placed(list(zip(radii * np.cos(angles), radii * np.sin(angles), strict=True)),
                         3, False)  # fmt: skip
        total = polygon_area_vector(polygon)
        area = np.linalg.norm(total)
        pieces = area_vectors(polygon, cut(polygon)) @ (total / area)
        assert pieces.min() > -1e-5 * area
        assert abs(pieces.sum() - area) < 1e-5 * area


def test_an_outline_of_twenty_thousand_corners_is_covered_once(rng: np.random.Generator) -> None:
    angles = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)
    radii = rng.uniform(0.3, 1.0, len(angles))
    polygon = placed(list(zip(radii * np.cos(angles), radii * np.sin(angles), strict=True)),
                     3, False)  # fmt: skip
    total = polygon_area_vector(polygon)
    area = np.linalg.norm(total)
    pieces = area_vectors(polygon, cut(polygon)) @ (total / area)
    assert len(pieces) == len(polygon) - 2
    assert pieces.min() > -1e-7 * area
    assert abs(pieces.sum() - area) < 1e-5 * area


def test_a_tangle_of_twenty_thousand_corners_ends(rng: np.random.Generator) -> None:
    """One without an ear to find would take 10^12 steps: the rest of it becomes a fan."""
    polygon = placed(list(map(tuple, rng.random((20_000, 2)))), 3, False)
    triangles = cut(polygon)
    assert triangles.shape == (len(polygon) - 2, 3)
    assert set(triangles.ravel().tolist()) == set(range(len(polygon)))
    assert (triangles[:, 0] == triangles[-1, 0]).sum() > 1000  # the fan
    total = area_vectors(polygon, triangles).sum(axis=0)
    assert np.allclose(total, polygon_area_vector(polygon), atol=1e-3)
