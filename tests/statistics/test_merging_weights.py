"""The weights of paths that are joined and merged: the recursive form equals the plain one.

Paths here are made of numbers alone, over many orders of magnitude: no scene would show them all.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from statistics_tools import Array

from engine_core import probe

PATHS = 400
#: Where the columns of a surface are that say what is possible there.
SINGULAR, REACHES, SEES, CROSSES, AREA = 8, 9, 10, 11, 12


def directions(rng: np.random.Generator, count: int) -> Array:
    d = rng.normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def random_path(
    rng: np.random.Generator, surfaces: int, decades: float
) -> tuple[list[list[float]], list[float]]:
    """A path whose densities spread over so many powers of ten."""

    def pdf(count: int) -> Array:
        return 10.0 ** rng.uniform(-decades, decades, count)

    rows = np.ones((surfaces, 13))
    rows[:, 0:3] = rng.normal(size=(surfaces, 3)) * 10.0 ** rng.uniform(-2, 2)
    rows[:, 3:6] = directions(rng, surfaces)
    rows[:, 6], rows[:, 7] = pdf(surfaces), pdf(surfaces)
    rows[:, SINGULAR] = rng.random(surfaces) < 0.25
    for column in (REACHES, SEES, CROSSES):
        rows[:, column] = rng.random(surfaces) < 0.95
    rows[:, AREA] = pdf(surfaces) * (rng.random(surfaces) < 0.9)
    ends = np.concatenate(
        [directions(rng, 1)[0], pdf(1), directions(rng, 1)[0], pdf(2), rng.random(2) < 0.8]
    )
    return rows.tolist(), ends.tolist()


@pytest.mark.parametrize("power", [False, True], ids=["balance", "power"])
@pytest.mark.parametrize("decades", [0.5, 4.0])
@pytest.mark.parametrize(
    ("joins", "merges"), [(True, True), (False, True), (True, False)], ids=["both", "merge", "join"]
)
def test_recursive_form_equals_plain_form(
    joins: bool, merges: bool, power: bool, decades: float, rng: np.random.Generator
) -> None:
    found = 0
    for _ in range(PATHS):
        surfaces = int(rng.integers(1, 8))
        plain, recursive = probe.mis_weights(
            *random_path(rng, surfaces, decades), power, joins, merges
        )
        assert len(plain) == surfaces + 2 + (surfaces if merges else 0)
        np.testing.assert_allclose(recursive, plain, rtol=1e-9, atol=1e-12)
        possible = sum(plain) > 0
        found += possible
        assert sum(plain) == pytest.approx(1 if possible else 0, abs=1e-9)
    assert found > PATHS / 3


def test_a_merge_weighs_as_many_joins_as_paths_arrive(rng: np.random.Generator) -> None:
    """By the balance heuristic weights stand as densities: Georgiev et al. 2012, equation 9."""
    rows, ends = random_path(rng, 3, 0.5)
    for row in rows:
        row[SINGULAR:] = [0, 1, 1, 1, 0.37]
    ends[9:] = [1, 1]
    plain, _ = probe.mis_weights(rows, ends, False, True, True)
    n = len(rows) + 2
    points, normals = np.array(rows)[:, 0:3], np.array(rows)[:, 3:6]
    by_light = []  # the area density of each surface but the last, by the walk from the light
    for (p, q), (normal, _), (_, row) in zip(
        pairwise(points), pairwise(normals), pairwise(rows), strict=True
    ):
        d2 = np.sum((q - p) ** 2)
        by_light.append(row[7] * abs(normal @ (q - p)) / d2**1.5)
    for i, density in enumerate(by_light):
        join_beyond = plain[n - (i + 2)]  # v_i is the camera's last, v_{i+1} the light's
        assert plain[n + i] == pytest.approx(join_beyond * density * 0.37, rel=1e-5)


def test_no_merging_at_singular_surfaces_nor_where_no_light_walks(
    rng: np.random.Generator,
) -> None:
    for _ in range(50):
        rows, ends = random_path(rng, 4, 0.5)
        plain, recursive = probe.mis_weights(rows, ends, True, True, True)
        for i, row in enumerate(rows):
            beyond = rows[i:]
            blocked = any(not other[REACHES] for other in beyond) or any(
                not other[CROSSES] for other in rows[i + 1 :]
            )
            if row[SINGULAR] or row[AREA] == 0 or blocked or not ends[10]:
                assert plain[6 + i] == recursive[6 + i] == 0
            else:
                assert plain[6 + i] > 0
