"""Both transport modes see one surface: adjoint values, reverse densities, delta distributions."""

from __future__ import annotations

from functools import reduce
from operator import or_

import numpy as np
import pytest
from bsdf_tools import (
    LOBES,
    ONLY_REFLECTION,
    ONLY_TRANSMISSION,
    SINGULAR,
    TRANSPARENT,
    Array,
    Samples,
    Surface,
    Values,
    closure,
    direction,
    single,
    sphere,
    surface,
    uniform,
)

from engine_core import probe

#: Surfaces by name: plain, and with bump-mapped and interpolated normals.
SURFACES: dict[str, Surface] = {name: surface(*lobes) for name, lobes in LOBES.items()}
SURFACES |= {
    f"{name} bent": surface(
        *({**c, "normal": (0.4, -0.2, 0.8)} for c in LOBES[name]), ns=(0.1, 0.0, 1.0)
    )
    for name in ("lambert", "oren_nayar", "ggx", "multi_ggx", "glass", "sheen", "principled_layers")
}
SURFACES |= {
    f"{name} from within": surface(*LOBES[name], backfacing=True)
    for name in ("glass", "glass_film", "principled_layers")
}


def pairs(s: Surface, rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Camera and light directions: half of them scattered by the surface, half anywhere."""
    camera = sphere(rng, count)
    light = sphere(rng, count)
    for i in range(0, count, 2):
        samples = Samples(s, camera[i : i + 1], uniform(rng, 8))
        if samples.smooth.any():
            light[i] = samples.wi[samples.smooth][0]
    return single(camera).astype(np.float64), single(light).astype(np.float64)


@pytest.mark.parametrize("name", SURFACES)
def test_modes_are_adjoint(name: str, rng: np.random.Generator) -> None:
    """One path, built from either end, has one value; each end's densities are the other's reverse.

    kImportance with light side given is F(c, l) |c.ng| / |l.ng|, kRadiance is F(c, l).
    """
    s = SURFACES[name]
    camera, light = pairs(s, rng, 300)
    radiance = Values(s, camera, light)
    importance = Values(s, light, camera, importance=True)
    factor = abs(camera[:, 2]) / abs(light[:, 2])
    expected = radiance.f * factor[:, None]
    assert (radiance.f > 0).any()
    scale = np.maximum(abs(expected), 1e-6)
    np.testing.assert_allclose(importance.f / scale, expected / scale, rtol=0, atol=2e-3)
    for a, b in (
        (radiance.pdf, importance.pdf_reverse),
        (radiance.pdf_reverse, importance.pdf),
    ):
        np.testing.assert_allclose(b, a, rtol=2e-3, atol=1e-6)


RECIPROCAL = [
    n
    for n in LOBES
    if n.split("_")[0] in ("lambert", "oren", "translucent", "beckmann", "ashikhmin", "velvet")
    or n in ("ggx", "ggx_rough", "ggx_anisotropic", "metallic_film")
]


@pytest.mark.parametrize("name", RECIPROCAL)
def test_lobes_are_reciprocal(name: str, rng: np.random.Generator) -> None:
    lobes = [{**c, "distribution": "GGX"} if c["kind"] == "metallic" else c for c in LOBES[name]]
    s = surface(*lobes)
    camera, light = pairs(s, rng, 300)
    there = Values(s, camera, light).f / abs(light[:, 2:])
    back = Values(s, light, camera).f / abs(camera[:, 2:])
    assert (there > 0).any()
    np.testing.assert_allclose(back, there, rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize("distribution", ["GGX", "BECKMANN"])
def test_refraction_is_reciprocal_but_for_the_squared_index(
    distribution: str, rng: np.random.Generator
) -> None:
    """F(c, l) / (|cos l| n_l^2) is symmetric: basic radiance (Veach 1997, section 5.2)."""
    ior = 1.5
    s = surface(closure("glass", roughness=0.6, distribution=distribution, ior=ior))
    camera, light = pairs(s, rng, 400)
    through = camera[:, 2] * light[:, 2] < 0
    camera, light = camera[through], light[through]
    index = np.where(light[:, 2] < 0, ior, 1.0) ** 2, np.where(camera[:, 2] < 0, ior, 1.0) ** 2
    there = Values(s, camera, light).f[:, 0] / abs(light[:, 2]) / index[0]
    back = Values(s, light, camera).f[:, 0] / abs(camera[:, 2]) / index[1]
    assert (there > 0).sum() > 50
    np.testing.assert_allclose(back, there, rtol=2e-3, atol=1e-6)


@pytest.mark.parametrize("importance", [False, True], ids=["radiance", "importance"])
@pytest.mark.parametrize("mask", [ONLY_REFLECTION, ONLY_TRANSMISSION])
@pytest.mark.parametrize("cosine", [0.9, 0.3])
@pytest.mark.parametrize("backfacing", [False, True])
def test_smooth_glass(
    backfacing: bool, cosine: float, mask: int, importance: bool, rng: np.random.Generator
) -> None:
    """Snell's law, Fresnel's sum, and the squared index in importance."""
    ior = 1.5
    eta = 1 / ior if backfacing else ior
    s = surface(closure("glass", ior=ior, roughness=0.0), backfacing=backfacing)
    wo = direction(cosine)
    sine = np.sqrt(1 - cosine**2) / eta
    samples = Samples(s, wo, uniform(rng, 50), importance=importance, mask=mask)
    if mask == ONLY_TRANSMISSION and sine >= 1:
        assert not samples.valid.any()
        return
    assert samples.singular.all()
    assert (Values(s, wo, samples.wi, importance=importance).f == 0).all()
    cos_t = np.sqrt(max(1 - sine**2, 0))
    r = 1.0
    if sine < 1:
        r_s = (cosine - eta * cos_t) / (cosine + eta * cos_t)
        r_p = (eta * cosine - cos_t) / (eta * cosine + cos_t)
        r = (r_s**2 + r_p**2) / 2
    if mask == ONLY_REFLECTION:
        np.testing.assert_allclose(samples.wi - wo * [-1, -1, 1], 0, atol=1e-6)
        np.testing.assert_allclose(samples.weight, r, rtol=1e-4)
        np.testing.assert_allclose(samples.eta, 1)
    else:
        expected = np.append(-wo[0, :2] / eta, -cos_t)
        np.testing.assert_allclose(samples.wi - expected, 0, atol=1e-6)
        np.testing.assert_allclose(samples.eta, eta, rtol=1e-6)
        adjoint = 1 / eta**2 if importance else 1.0
        np.testing.assert_allclose(samples.weight, (1 - r) * adjoint, rtol=1e-4)


@pytest.mark.parametrize("importance", [False, True], ids=["radiance", "importance"])
def test_singular_events_have_reverse_probabilities(
    importance: bool, rng: np.random.Generator
) -> None:
    """The way back is chosen with the probability that the way there states."""
    s = surface(
        closure("principled", roughness=0.0, transmission_weight=0.6, coat_weight=0.4, alpha=0.8)
    )
    wo = direction(0.6)
    samples = Samples(s, wo, uniform(rng, 400), importance=importance)
    seen = set()
    for i in np.flatnonzero(samples.singular):
        lobe = int(samples.lobe[i])
        back = Samples(s, samples.wi[i : i + 1], uniform(rng, 200), importance=not importance)
        near = abs(back.wi - wo).max(axis=1) < 1e-5
        # Lobes that share a direction (coat and base) keep their own probabilities.
        match = near & (back.lobe == lobe)
        match &= abs(back.pdf_reverse - samples.pdf[i]) < 1e-4
        if match.any():
            seen.add(lobe)
            assert np.min(abs(back.pdf[match] - samples.pdf_reverse[i])) < 1e-4
    assert {x & (TRANSPARENT | 4 | 8) for x in seen} == {4, 8, TRANSPARENT}


@pytest.mark.parametrize("kind", ["glossy", "glass", "refraction"])
@pytest.mark.parametrize("importance", [False, True], ids=["radiance", "importance"])
def test_the_delta_limit_is_continuous(
    kind: str, importance: bool, rng: np.random.Generator
) -> None:
    """Just above the singular roughness (alpha 1.42e-5) all is as just below, within noise."""
    results = []
    for roughness in (0.00375, 0.0038):
        s = surface(closure(kind, roughness=roughness, distribution="GGX"))
        wo = direction(0.7)
        u = uniform(np.random.default_rng(5), 20_000)
        samples = Samples(s, wo, u, importance=importance)
        results.append((samples, [samples.weight.mean(), samples.wi.mean(axis=0)]))
    below, above = results
    assert below[0].singular[below[0].valid].all()
    assert above[0].smooth[above[0].valid].all()
    for a, b in zip(below[1], above[1], strict=True):
        np.testing.assert_allclose(a, b, atol=2e-3)


def test_lobes_say_what_may_be_sampled(rng: np.random.Generator) -> None:
    for lobes in LOBES.values():
        s = surface(*lobes)
        info = probe.bsdf_info(s, single(direction(0.5)))
        drawn = Samples(s, direction(0.5), uniform(rng, 3000))
        union = reduce(or_, drawn.lobe.tolist())
        assert union & ~info["lobes"] == 0
        assert info["connectible"] == bool(drawn.smooth.any())
        assert bool(union & SINGULAR) == bool(info["lobes"] & SINGULAR)


def test_too_many_lobes_drop_the_weakest() -> None:
    lobes = [closure("diffuse", weight=(w, w, w)) for w in np.linspace(0.01, 0.15, 15)]
    info = probe.bsdf_info(surface(*lobes), single(direction(0.5)))
    assert info["overflow"] == 3
    kept = sum(w for w in np.linspace(0.01, 0.15, 15)[3:])
    np.testing.assert_allclose(info["albedo"], kept, rtol=1e-6)
