"""Scale, place, sharpness and length change no picture of the bidirectional methods."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from bidirectional_scenes import apart, build, glossy, graph, scaled
from engine_core.description import Graph, Link, Node
from scenes import SceneBuilder, box, pictures, quad
from statistics_tools import Array, assert_equal_means, assert_mean_is

SEEDS = 8


def shots(builder: SceneBuilder, **settings: Any) -> Array:
    """Every sample finite: `render` checks it."""
    return pictures(builder, SEEDS, **{"integrator": "BDPT", "samples": 64, **settings})


@pytest.mark.parametrize("integrator", ["BDPT", "LIGHT"])
@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("view", ["pinhole", "focus_blades", "orthographic_focus"])
def test_scale(view: str, scale: float, integrator: str) -> None:
    scene = partial(apart, "many", view)
    settings = {"integrator": integrator, "max_bounces": 4}
    assert_equal_means(shots(scene(), **settings), shots(scaled(scene(), scale), **settings))


@pytest.mark.parametrize("integrator", ["BDPT", "LIGHT"])
def test_place(integrator: str) -> None:
    """A million units away, where float32 resolves a sixteenth of one: the scene is large."""
    scene = partial(apart, "many", "pinhole")
    settings = {"integrator": integrator, "max_bounces": 4}
    here, there = scaled(scene(), 4096.0), scaled(scene(), 4096.0, 2.0**20)
    assert_equal_means(shots(here, **settings), shots(there, **settings))


def sharp(scene: SceneBuilder) -> SceneBuilder:
    scene.add(quad((-1.9, 0, 0.2), (0.8, 0.9, 0), (0, 0, 1.5)), graph(glossy(1e-2)))
    return scene


@pytest.mark.parametrize(
    "builder",
    [
        lambda: sharp(build("diffuse", "area")),
        lambda: build("near_mirror", "area"),
        lambda: build("oren_nayar", "area_tiny"),
        lambda: build("glossy", "point"),
    ],
)
def test_sharp_lobes_and_small_lights(builder: Callable[[], SceneBuilder]) -> None:
    path = pictures(builder(), SEEDS, samples=256, max_bounces=4)
    assert_equal_means(path, shots(builder(), max_bounces=4))


def white_box(albedo: float) -> SceneBuilder:
    """A closed room that shines as much as it absorbs: radiance 1 everywhere (a furnace)."""
    scene = SceneBuilder((8, 8))
    walls = Graph(
        [
            Node("ShaderNodeBsdfDiffuse", inputs={"Color": (albedo,) * 3 + (1.0,)}),
            Node("ShaderNodeEmission", inputs={"Strength": 1.0 - albedo}),
            Node("ShaderNodeAddShader", inputs={"Shader": Link(0, "BSDF"),
                                                "Shader_001": Link(1, "Emission")}),
        ],
        Link(2, "Shader"),
    )  # fmt: skip
    scene.add(box((-1, -1, 0), (1, 1, 2), inward=True), walls)
    scene.camera((0, -0.9, 1), (0, 0.5, 0.9), fov=70)
    return scene


@pytest.mark.parametrize("integrator", ["BDPT", "LIGHT"])
def test_a_furnace(integrator: str) -> None:
    """Paths of a hundred vertices and more carry what they should."""
    settings = {"integrator": integrator, "roulette_threshold": 0.0, "max_bounces": 100}
    albedo = 0.9
    truth = 1.0 - albedo**101
    assert_mean_is(shots(white_box(albedo), samples=16, **settings).mean(axis=(1, 2)), truth)


def test_roughness_and_area_at_their_least_are_finite() -> None:
    """A mirror lobe of roughness 1e-4 and a light of 1e-8 square metres: non_finite stays 0."""
    scene = build("diffuse", "area_tiny")
    scene.add(quad((-1.9, 0, 0.2), (0.8, 0.9, 0), (0, 0, 1.5)), graph(glossy(1e-4)))
    image = shots(scene, max_bounces=6)
    assert np.isfinite(image).all()
    assert image.mean() > 0
