"""sample() draws from the density that eval() states, for every lobe, angle and transport mode."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bsdf_tools import (
    LOBES,
    ONLY_REFLECTION,
    ONLY_TRANSMISSION,
    Array,
    Samples,
    Surface,
    Values,
    closure,
    direction,
    sphere,
    surface,
    uniform,
)
from statistics_tools import assert_chi_squared

COUNT = 20_000


def frame(axis: Array) -> Array:
    """Rows: two tangents and the axis."""
    a = axis / np.linalg.norm(axis)
    helper = np.eye(3)[np.argmin(abs(a))]
    t = np.cross(helper, a)
    t /= np.linalg.norm(t)
    return np.stack([t, np.cross(a, t), a])


def check(
    s: Surface, wo: Array, u: Array, axis: Array, edges: Array, nodes: int = 12, **options: Any
) -> None:
    """Chi-squared over rings of polar angle `edges` about an axis by sectors of azimuth.

    The density is integrated by `nodes` squared Gauss points per cell. What no cell holds (samples
    that were lost or singular) is one more cell.
    """
    sectors = 12
    basis = frame(axis)
    x, w = np.polynomial.legendre.leggauss(nodes)
    x, w = (x + 1) / 2, w / 2
    theta = (edges[:-1, None] + x * np.diff(edges)[:, None]).ravel()
    theta_weight = (w * np.diff(edges)[:, None]).ravel() * np.sin(theta)
    step = 2 * np.pi / sectors
    phi = (step * (np.arange(sectors)[:, None] + x)).ravel()
    phi_weight = np.tile(w * step, sectors)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    local = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1).reshape(-1, 3)
    pdf = Values(s, wo, local @ basis, **options).pdf.reshape(t.shape)
    mass = (pdf * np.outer(theta_weight, phi_weight)).reshape(len(edges) - 1, nodes, sectors, nodes)
    expected = mass.sum(axis=(1, 3)) * len(u)

    samples = Samples(s, wo, u, **options)
    v = samples.wi[samples.smooth] @ basis.T
    # The angle from both coordinates: arccos has no digits left near the axis.
    polar = np.arctan2(np.hypot(v[:, 0], v[:, 1]), v[:, 2])
    azimuth = np.arctan2(v[:, 1], v[:, 0]) % (2 * np.pi)
    observed = np.histogram2d(polar, azimuth, [edges, np.arange(sectors + 1) * step])[0]
    rest = len(u) - len(v)
    assert_chi_squared(
        np.append(observed.ravel(), rest),
        np.append(expected.ravel(), max(len(u) - expected.sum(), 0.0)),
    )


def nodes_for(name: str) -> int:
    """Rough refraction has an edge, where facets are seen from the side, that crosses cells."""
    if "refraction" in name:
        return 80
    return 40 if "glass" in name else 12


@pytest.mark.parametrize("importance", [False, True], ids=["radiance", "importance"])
@pytest.mark.parametrize("cosine", [1.0, 0.7, 0.12])
@pytest.mark.parametrize("name", LOBES)
def test_samples_follow_the_density(
    name: str, cosine: float, importance: bool, rng: np.random.Generator
) -> None:
    edges = np.linspace(0, np.pi, 21)
    check(
        surface(*LOBES[name]),
        direction(cosine),
        uniform(rng, COUNT),
        np.array([0.0, 0.0, 1.0]),
        edges,
        nodes=nodes_for(name),
        importance=importance,
    )


@pytest.mark.parametrize("importance", [False, True], ids=["radiance", "importance"])
@pytest.mark.parametrize(
    "name",
    ["lambert", "oren_nayar", "translucent", "ggx", "glass", "sheen", "principled_layers"],
)
def test_samples_follow_the_density_under_bent_normals(
    name: str, importance: bool, rng: np.random.Generator
) -> None:
    """Bump-mapped: samples below the geometry are lost, and the density says so."""
    bent = [{**c, "normal": (0.5, 0.2, 0.8)} for c in LOBES[name]]
    s = surface(*bent, ns=(0.1, 0.0, 1.0))
    for wo in (direction(0.6), direction(0.15, 3.5)):
        edges = np.linspace(0, np.pi, 21)
        axis, nodes = np.array([0.0, 0.0, 1.0]), nodes_for(name)
        check(s, wo, uniform(rng, COUNT), axis, edges, nodes=nodes, importance=importance)


@pytest.mark.parametrize("importance", [False, True], ids=["radiance", "importance"])
@pytest.mark.parametrize(
    ("roughness", "cosine"),
    # At grazing angles the facet's normal is a difference of nearly opposite unit vectors, whose
    # rounding (6e-8 / cosine) must stay far below alpha.
    [(r, c) for r in (0.004, 0.03, 0.2) for c in (0.9, 0.3, 0.02) if (r, c) != (0.004, 0.02)],
)
@pytest.mark.parametrize("distribution", ["GGX", "BECKMANN"])
def test_sharp_reflections_follow_the_density(
    distribution: str, roughness: float, cosine: float, importance: bool, rng: np.random.Generator
) -> None:
    """Rings that widen from the mirror direction, down to alpha 1.6e-5."""
    wo = direction(cosine)
    s = surface(closure("glass", roughness=roughness, distribution=distribution, ior=1.5))
    mirrored = wo[0] * [-1, -1, 1]
    edges = np.concatenate([[0], np.geomspace(roughness**2 / 8, np.pi, 32)])
    u = uniform(rng, COUNT)
    check(s, wo, u, mirrored, edges, importance=importance, mask=ONLY_REFLECTION)


@pytest.mark.parametrize("importance", [False, True], ids=["radiance", "importance"])
@pytest.mark.parametrize(
    ("roughness", "ior"),
    # Likewise the rounding is 6e-8 / |ior - 1| here.
    [(r, i) for r in (0.004, 0.03, 0.2) for i in (1.5, 0.75, 1.02) if (r, i) != (0.004, 1.02)],
)
def test_sharp_refractions_follow_the_density(
    roughness: float, ior: float, importance: bool, rng: np.random.Generator
) -> None:
    wo = direction(0.8)
    s = surface(closure("glass", roughness=roughness, ior=ior))
    sine = np.sqrt(1 - 0.8**2) / ior
    refracted = direction(-np.sqrt(1 - sine**2), 0.4 + np.pi)[0]
    edges = np.concatenate([[0], np.geomspace(abs(ior - 1) * roughness**2 / 8, np.pi, 32)])
    u = uniform(rng, COUNT)
    check(s, wo, u, refracted, edges, importance=importance, mask=ONLY_TRANSMISSION)


@pytest.mark.parametrize("importance", [False, True], ids=["radiance", "importance"])
@pytest.mark.parametrize("name", LOBES)
def test_weights_are_values_over_densities(
    name: str, importance: bool, rng: np.random.Generator
) -> None:
    s = surface(*LOBES[name])
    for wo in (direction(0.9), direction(0.4), direction(0.03)):
        u = uniform(rng, 2000)
        samples = Samples(s, wo, u, importance=importance)
        assert samples.valid.any()
        ok = samples.smooth
        e = Values(s, wo, samples.wi[ok], importance=importance)
        np.testing.assert_allclose(
            samples.weight[ok] * samples.pdf[ok, None], e.f, rtol=2e-6, atol=1e-30
        )
        np.testing.assert_allclose(samples.pdf[ok], e.pdf, rtol=1e-6)
        np.testing.assert_allclose(samples.pdf_reverse[ok], e.pdf_reverse, rtol=1e-6)
        forward = Samples(s, wo, u, importance=importance, forward=True)
        np.testing.assert_allclose(forward.weight, samples.weight, rtol=1e-6)
        np.testing.assert_allclose(forward.pdf, samples.pdf, rtol=1e-6)
        assert (forward.pdf_reverse == 0).all()
        value = Values(s, wo, samples.wi[ok], importance=importance, forward=True)
        np.testing.assert_allclose(value.f, e.f, rtol=1e-6)
        assert (value.pdf_reverse == 0).all()


def test_masks_split_the_value(rng: np.random.Generator) -> None:
    s = surface(*LOBES["principled_layers"])
    wo, wi = direction(0.6), sphere(rng, 1000)
    diffuse, glossy = 1, 2
    total = Values(s, wo, wi).f
    parts = sum(
        Values(s, wo, wi, mask=ray | side).f for ray in (diffuse, glossy) for side in (4, 8)
    )
    np.testing.assert_allclose(parts, total, rtol=1e-5, atol=1e-9)
    assert (Values(s, wo, wi, mask=4).f == 0).all()


@pytest.mark.parametrize("mask", [1 | 4, 2 | 4, 2 | 8])
def test_samples_of_a_mask_follow_its_density(mask: int, rng: np.random.Generator) -> None:
    s = surface(*LOBES["principled_layers"])
    edges = np.linspace(0, np.pi, 21)
    axis = np.array([0.0, 0.0, 1.0])
    for importance in (False, True):
        u = uniform(rng, COUNT)
        check(s, direction(0.5), u, axis, edges, importance=importance, mask=mask)
        lobes = Samples(s, direction(0.5), u, importance=importance, mask=mask).lobe
        assert (lobes & ~mask == 0).all()
