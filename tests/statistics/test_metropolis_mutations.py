"""Each mutation of whole paths alone: what it leaves unchanged, and the densities it goes by."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from bidirectional_scenes import MATERIALS, build
from scenes import Array, SceneBuilder, diffuse, emission, quad, sphere
from scipy import stats
from statistics_tools import sidak

import engine_core
from engine_core import probe

SEEDS, STEPS, SIDE, LONGEST = 10, 30_000, 3, 6
MUTATIONS = ["bidirectional", "camera", "light", "lens"]


def under_glass() -> SceneBuilder:
    """A floor seen through a pane of glass, lit through it, beside a mirror."""
    scene = SceneBuilder((12, 12))
    scene.add(quad((-2, -2, 0), (4, 0, 0), (0, 4, 0)), diffuse(0.7))
    scene.add(quad((-2, -2, 0.8), (4, 0, 0), (0, 4, 0)), MATERIALS["glass"])
    scene.add(sphere(0.4, (0.6, 0.4, 0.4), rings=6), MATERIALS["mirror"])
    scene.add(sphere(0.4, (-0.6, 0.2, 1.6), rings=6), diffuse(0.5))
    scene.camera((0.3, -4.0, 3.0), (0, 0, 0.5), fov=40)
    scene.add(quad((-1.5, -1.5, 2.5), (3, 0, 0), (0, 3, 0)), emission(3.0))
    return scene


def scene_named(name: str) -> SceneBuilder:
    return under_glass() if name == "under_glass" else build(*name.split(":"))


@cache
def compiled(name: str) -> Any:
    return engine_core.compile(scene_named(name).description, threads=1)


SETTINGS = {"integrator": "MLT", "max_bounces": 5, "threads": 1, "samples": 64}


@cache
def visits(name: str, mutation: str) -> tuple[Array, float]:
    """Shares of visits: (seeds, cells); and how often the mutation was accepted."""
    chains = [
        probe.mutation_chain(compiled(name), SETTINGS, mutation, STEPS, seed, SIDE, LONGEST)
        for seed in range(SEEDS)
    ]
    shares = np.array([c["visits"] for c in chains]) / STEPS
    return shares, float(np.mean([c["accepted"] for c in chains]))


SCENES = ["principled:area", "glossy:point", "glass:sky", "under_glass", "mirror:sun_disk:focus"]
# A sheet that lets light straight through, as much as its angle says.
CLEAR = ["glass:area:focus:facing_sheet"]


@pytest.mark.parametrize("mutation", MUTATIONS)
@pytest.mark.parametrize("name", SCENES + CLEAR)
def test_mutations_leave_the_distribution_of_independent_paths(name: str, mutation: str) -> None:
    """By place in the frame and number of surfaces, against chains of independent paths alone."""
    reference, _ = visits(name, "new")
    mutated, _ = visits(name, mutation)
    a, b = reference.mean(axis=0), mutated.mean(axis=0)
    va, vb = reference.var(axis=0, ddof=1) / SEEDS, mutated.var(axis=0, ddof=1) / SEEDS
    often = (reference > 0).all(axis=0) & (mutated > 0).all(axis=0) & (a > 3e-3)
    assert often.sum() > 5
    t = (b - a)[often] / np.sqrt((va + vb)[often])
    freedom = (va + vb) ** 2 / (va**2 / (SEEDS - 1) + vb**2 / (SEEDS - 1) + 1e-300)
    p = 2 * stats.t.sf(abs(t), freedom[often])
    assert p.min() > sidak(p.size), f"{b[often][p.argmin()]:.4f}, not {a[often][p.argmin()]:.4f}"


@pytest.mark.parametrize("mutation", MUTATIONS)
def test_mutations_are_accepted_where_they_suit(mutation: str) -> None:
    assert max(visits(name, mutation)[1] for name in SCENES) > 0.03


def by_brute_force(row: dict[str, Any], a: int, b: int) -> float:
    """The density of growing all but the first a and last b surfaces, technique by technique."""
    singular, passes = row["singular"], row["log_passes"]
    k = len(singular)
    # A walk passes what it does by chance, and stops where it stops; what is joined is seen.
    camera = [row["log_camera"][i] + passes[i] + row["log_stops_camera"][i] for i in range(k)]
    light = [row["log_light"][i] + passes[i + 1] + row["log_stops_light"][i] for i in range(k)]
    c = k - a - b
    total = 0.0
    for from_camera in range(c + 1):
        split = a + from_camera  # the surfaces before it are the camera's
        by_camera = math.exp(sum(camera[a:split]))
        by_light = math.exp(sum(light[i] - row["log_refraction"][i] for i in range(split, k - b)))
        left_free = split == 0 or not singular[split - 1]
        if split < k:
            if left_free and not singular[split]:
                total += by_camera * by_light
        elif split > 0:
            if left_free:
                total += by_camera * row["pdf_sampled"]
            total += by_camera * row["pdf_to_light"][k - 1] * row["pdf_met"]
    return total / (c + 1 if b > 0 else c + 2)


@pytest.mark.parametrize("name", SCENES + CLEAR)
def test_transition_densities(name: str) -> None:
    rows = probe.grown_densities(compiled(name), SETTINGS, 300, 3)
    compared = 0
    for row in rows:
        for (a, b), log in row["grown"].items():
            expected = by_brute_force(row, a, b)
            assert math.exp(log) == pytest.approx(expected, rel=1e-3, abs=0.0)
            compared += expected > 0
    assert compared > 1000
    assert (name in CLEAR) == any(sum(row["log_passes"]) < 0 for row in rows)
