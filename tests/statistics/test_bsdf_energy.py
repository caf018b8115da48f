"""Energy: white furnaces, albedos, layers, and no value that is not finite at any extreme."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bsdf_tools import (
    LOBES,
    Array,
    Samples,
    Surface,
    Values,
    closure,
    direction,
    single,
    sphere,
    surface,
)
from scipy.stats import qmc

from engine_core import probe

WHITE = (1.0, 1.0, 1.0)
COUNT = 1 << 15


def albedo(s: Surface, cosine: float, **options: Any) -> tuple[Array, Array]:
    """Mean and standard error of the weights: the directional albedo."""
    u = qmc.Sobol(3, seed=3).random(COUNT)
    weight = Samples(s, direction(cosine), np.minimum(u, 1 - 2.0**-24), **options).weight
    blocks = weight.reshape(COUNT // 16, 16, 3).mean(axis=0)
    return weight.mean(axis=0), blocks.std(axis=0, ddof=1) / 4


#: Closures that lose nothing, and how far below 1 their albedo may be by the tables' coarseness.
LOSSLESS = {
    "lambert": (closure("diffuse"), 1e-5),
    "oren_nayar": (closure("diffuse", roughness=1.0, color=WHITE), 2e-3),
    "translucent": (closure("translucent"), 1e-5),
    "multi_ggx": (closure("glossy", roughness=0.5, color=WHITE), 0.012),
    "multi_ggx_rough": (closure("glossy", roughness=1.0, color=WHITE), 0.012),
    "metallic": (
        closure("metallic", base_color=WHITE, edge_tint=WHITE, roughness=0.7),
        0.012,
    ),
    "glass": (closure("glass", roughness=0.5), 0.02),
    "glass_rough": (closure("glass", roughness=1.0, ior=1.33), 0.02),
    "smooth_glass": (closure("glass", roughness=0.0), 1e-4),
    "mirror": (closure("glossy", roughness=0.0), 1e-5),
}


@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.15])
@pytest.mark.parametrize("name", LOSSLESS)
def test_white_furnace(name: str, cosine: float) -> None:
    lobe, tolerance = LOSSLESS[name]
    mean, error = albedo(surface(lobe), cosine)
    noise = 5 * error + 1e-4
    assert (abs(mean - 1) <= tolerance + noise).all(), mean


@pytest.mark.parametrize("roughness", [0.0, 0.2, 0.5, 1.0])
def test_glass_from_within_gains_nothing(roughness: float) -> None:
    """From the denser side some light is lost at grazing angles, as in Cycles; never gained."""
    s = surface(closure("glass", roughness=roughness), backfacing=True)
    for cosine in (1.0, 0.6, 0.2):
        mean, error = albedo(s, cosine)
        assert (mean <= 1.012 + 5 * error).all()
        assert (mean >= 0.5).all()


@pytest.mark.parametrize("cosine", [0.95, 0.4, 0.1])
def test_principled_reflects_no_more_than_it_gets(cosine: float) -> None:
    rng = np.random.default_rng(11)
    for _ in range(25):
        parameters = {
            key: float(rng.random())
            for key in (
                "metallic",
                "roughness",
                "diffuse_roughness",
                "transmission_weight",
                "coat_weight",
                "coat_roughness",
                "sheen_weight",
                "sheen_roughness",
                "alpha",
                "specular_ior_level",
            )
        }
        s = surface(closure("principled", base_color=WHITE, **parameters))
        mean, error = albedo(s, cosine)
        # Cycles' estimate of a layer's albedo is what it takes from below: near, not exact.
        assert (mean <= 1.03 + 5 * error).all(), (parameters, mean)


@pytest.mark.parametrize("name", LOBES)
def test_stated_albedo_is_near(name: str) -> None:
    s = surface(*LOBES[name])
    for cosine in (0.9, 0.5):
        stated = np.array(probe.bsdf_info(s, single(direction(cosine)))["albedo"])
        mean, error = albedo(s, cosine)
        if LOBES[name][0]["kind"] in ("toon", "velvet") or "ashikhmin" in name:
            assert (stated >= mean - 5 * error - 1e-3).all()  # Cycles states their weight
        else:
            plain = any(c.get("distribution") in ("GGX", "BECKMANN") for c in LOBES[name])
            # Stated without what single scattering loses; films as if the surface were smooth.
            lost = 0.7 if plain or "film" in name or name in ("refraction", "mix") else 0.06
            assert (abs(mean - stated) <= lost * stated + 5 * error + 1e-3).all(), (mean, stated)


def test_layers_attenuate_by_what_the_camera_sees() -> None:
    """Coat over black and over white: what the coat reflects is missing from the base."""
    coat = {"coat_weight": 1.0, "coat_roughness": 0.2, "specular_ior_level": 0.0}
    for cosine in (0.9, 0.3):
        black, _ = albedo(surface(closure("principled", base_color=(0, 0, 0), **coat)), cosine)
        white, error = albedo(surface(closure("principled", base_color=WHITE, **coat)), cosine)
        assert (abs(white - 1) < 0.02 + 5 * error).all()
        assert (black > 0.03).all()
        assert (black < 0.5).all()


def test_transparency_and_emission() -> None:
    wo = single(direction(0.5))
    glow = closure("principled", alpha=0.25, emission_color=(1.0, 0.5, 0.0), emission_strength=8.0)
    info = probe.bsdf_info(surface(glow), wo)
    np.testing.assert_allclose(info["transparency"], 0.75)
    np.testing.assert_allclose(info["emission"], (2.0, 1.0, 0.0))
    coated = probe.bsdf_info(surface({**glow, "coat_weight": 1.0}), wo)["emission"]
    assert 0.5 * 2 < coated[0] < 2
    samples = Samples(surface(glow), direction(0.5), np.random.default_rng(1).random((4000, 3)))
    through = (samples.lobe & 32) > 0
    np.testing.assert_allclose(samples.wi[through], np.tile(-wo, (int(through.sum()), 1)))
    np.testing.assert_allclose(
        samples.weight[through] * samples.pdf[through, None], 0.75, rtol=1e-5
    )


def test_thin_films_fade_out() -> None:
    """No film at thickness 0, and a continuous way there."""
    wo, wi = direction(0.7), direction(0.7, 0.4 + np.pi)
    for kind in ("glass", "metallic", "principled"):
        values = [
            Values(surface(closure(kind, roughness=0.5, film=(d, 1.6))), wo, wi).f
            for d in (0.0, 0.11, 5.0, 400.0)
        ]
        np.testing.assert_allclose(values[1], values[0], rtol=0.03)
        np.testing.assert_allclose(values[2], values[0], rtol=0.1)
        assert (abs(values[3] / values[0] - 1) > 0.05).any()


EXTREMES: dict[str, list[Any]] = {
    "roughness": [0.0, 1e-6, 3.7e-3, 3.8e-3, 0.02, 0.5, 1.0, 2.0, -1.0],
    "ior": [0.0, 1e-3, 0.5, 1.0, 1.00009, 1.0002, 1.5, 1e3, 1e30],
    "weight": [WHITE, (0.0, 0.0, 0.0), (1e30, 0.0, 1.0), (1e-6, 1e-3, 1e30), (-1.0, 0.5, 0.5)],
    "film": [(0.0, 1.0), (0.5, 1e-3), (500.0, 1.3), (1e6, 1e3)],
    "anisotropy": [0.0, 0.99, 1.0, -1.0],
    "anisotropic": [0.0, 0.5, 1.0],
    "distribution": ["GGX", "MULTI_GGX", "BECKMANN", "ASHIKHMIN_SHIRLEY"],
    "color": [WHITE, (0.0, 0.0, 0.0), (1e30, 1.0, 0.5)],
    "base_color": [WHITE, (0.0, 0.0, 0.0), (1e30, 1.0, 0.5)],
    "edge_tint": [WHITE, (0.0, 0.0, 0.0)],
    "extinction": [(0.0, 0.0, 0.0), (1e-3, 1.0, 1e3), (1e30, 1e30, 0.0)],
    "coat_tint": [WHITE, (0.0, 0.5, 1e3)],
    "coat_ior": [1.0, 1.5, 1e3],
    "specular_tint": [WHITE, (0.0, 1.0, 1e3)],
    "specular_ior_level": [0.0, 0.5, 1.0, 1e3],
    "thin_wall": [False, True],
    "glossy": [False, True],
    "physical": [False, True],
}
UNIT = [
    "metallic",
    "transmission_weight",
    "coat_weight",
    "coat_roughness",
    "sheen_weight",
    "sheen_roughness",
    "alpha",
    "diffuse_roughness",
    "subsurface_weight",
    "size",
    "smooth",
]
NAMES = {
    "diffuse": ["roughness", "color"],
    "glossy": ["roughness", "anisotropy", "distribution", "color"],
    "metallic": ["roughness", "anisotropy", "distribution", "physical", "film", "base_color",
                 "edge_tint", "extinction"],
    "glass": ["roughness", "ior", "distribution", "film", "color"],
    "refraction": ["roughness", "ior", "distribution"],
    "sheen": ["roughness"],
    "velvet": ["roughness"],
    "toon": ["glossy", "size", "smooth"],
    "principled": ["roughness", "ior", "film", "anisotropic", "base_color", "coat_tint", "coat_ior",
                   "specular_tint", "specular_ior_level", "thin_wall", *UNIT[:9]],
}  # fmt: skip


@pytest.mark.parametrize("kind", NAMES)
def test_extremes_stay_finite(kind: str) -> None:
    rng = np.random.default_rng(7)

    def pick(key: str) -> Any:
        choices = EXTREMES.get(key, [0.0, 1e-6, 0.3, 1.0])
        return choices[rng.integers(len(choices))]

    directions = np.concatenate([
        direction(1.0), direction(0.6), direction(1e-3), direction(1e-7), direction(1e-20),
        sphere(rng, 40),
    ])  # fmt: skip
    corners = np.array([[a, b, c] for a in (0, 1) for b in (0, 1) for c in (0, 1)])
    u = np.minimum(np.concatenate([rng.random((100, 3)), corners]), 1 - 2.0**-24)
    for trial in range(150):
        parameters = {key: pick(key) for key in ["weight", *NAMES[kind]]}
        if kind == "principled" or "anisotropy" in parameters:
            parameters["tangent"] = [(1.0, 0.2, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)][trial % 3]
        normal = [(0.0, 0.0, 1.0), (0.8, 0.1, 0.6), (1.0, 0.0, 1e-4)][rng.integers(3)]
        s = surface(
            closure(kind, normal=normal, **parameters),
            ns=(0.05 * (trial % 2), 0.0, 1.0),
            backfacing=bool(rng.integers(2)),
        )
        wo = directions[rng.integers(len(directions)), None]
        for importance in (False, True):
            samples = Samples(s, wo, u, importance=importance)
            wi = np.concatenate([directions, -directions, samples.wi[samples.valid], -wo, wo])
            e = Values(s, wo, wi, importance=importance)
            info = probe.bsdf_info(s, single(wo))
            for values in (e.f, e.pdf, e.pdf_reverse, samples.weight, samples.pdf,
                           samples.pdf_reverse, samples.eta, info["albedo"],
                           info["mean_squared_roughness"]):  # fmt: skip
                assert np.isfinite(values).all(), (parameters, normal, wo)
                assert (np.asarray(values) >= 0).all(), (parameters, normal, wo)
            lengths = np.linalg.norm(samples.wi[samples.valid], axis=1)
            assert (abs(lengths - 1) < 1e-5).all(), (parameters, normal, wo)
