"""Estimators with the same expectation agree, block by block, over several seeds."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from engine_core.description import Graph, Light, Link, Node
from scenes import (
    SceneBuilder,
    background,
    box,
    diffuse,
    emission,
    picture,
    pictures,
    placed,
    quad,
    shader,
    sphere,
)
from statistics_tools import Array, assert_equal_means, assert_mean_is

SEEDS = 10


def room() -> SceneBuilder:
    """A box with a ceiling light, a glossy sphere, a mirror and a matte box."""
    scene = SceneBuilder((16, 16))
    scene.add(box((-1, -1, 0), (1, 1, 2), inward=True), diffuse((0.7, 0.5, 0.4)))
    scene.add(quad((-0.5, 0.5, 1.98), (1, 0, 0), (0, -1, 0)), emission(5.0))
    glossy = shader("ShaderNodeBsdfAnisotropic", Color=(0.8, 0.8, 0.8, 1), Roughness=0.4)
    scene.add(sphere(0.35, (-0.4, 0.2, 0.4), rings=16), glossy)
    mirror = shader("ShaderNodeBsdfAnisotropic", Color=(0.9, 0.9, 0.9, 1), Roughness=0.0)
    scene.add(quad((0.95, -0.5, 0.3), (0, 1, 0), (0, 0, 1)), mirror)
    scene.add(box((0.2, -0.3, 0), (0.6, 0.1, 0.7)), diffuse(0.6))
    scene.camera((0, -0.95, 1), (0, 0.5, 0.8), fov=80)
    return scene


def lamps() -> SceneBuilder:
    """Lamps of every kind over a floor, under a dim world."""
    scene = SceneBuilder((16, 16))
    scene.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.6))
    scene.add(box((-0.3, -0.3, 0.2), (0.3, 0.3, 0.8)), diffuse(0.8))
    for kind, x, fields in (
        ("POINT", -1.0, {"radius": 0.2}),
        ("SPOT", 0.0, {"radius": 0.1, "spot_angle": 1.2}),
        ("AREA", 1.0, {"size_x": 0.5, "size_y": 0.3}),
    ):
        scene.light(kind, transform=placed(1, (x, 0.6, 1.5)), emission=(20, 20, 20), **fields)
    scene.light("SUN", emission=(0.5, 0.5, 0.5), sun_angle=0.3)
    scene.description.world = background(0.1)
    scene.camera((0, -4, 3), (0, 0, 0.3))
    return scene


def studio() -> SceneBuilder:
    """Things of every sharpness before a matte wall, under a plain world alone."""
    scene = SceneBuilder((16, 16))
    scene.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.6))
    scene.add(box((-2, 0.7, 0), (2, 0.9, 2)), diffuse(0.3))
    for x, roughness in ((-0.7, 0.4), (0.0, 0.5), (0.7, 1.0)):
        glossy = shader("ShaderNodeBsdfAnisotropic", Color=(0.9, 0.7, 0.8, 1), Roughness=roughness)
        scene.add(sphere(0.28, (x, 0, 0.3), rings=12), glossy)
    scene.description.world = background(1.5)
    scene.camera((0, -4, 2), (0, 0, 0.3), fov=40)
    return scene


SCENES = {"room": room, "lamps": lamps, "studio": studio}


@cache
def reference(name: str) -> Array:
    return pictures(SCENES[name](), SEEDS, samples=64)


@pytest.mark.parametrize("direct_light", ["LIGHT", "BSDF", "UNIFORM", "MIXTURE"])
@pytest.mark.parametrize("name", SCENES)
def test_direct_light_estimators_agree(name: str, direct_light: str) -> None:
    other = pictures(SCENES[name](), SEEDS, samples=128, direct_light=direct_light)
    assert_equal_means(reference(name), other)


@pytest.mark.parametrize(
    "settings",
    [
        {"roulette_threshold": 0.1},
        {"roulette_start": 0},
        {"roulette_threshold": 0.0, "max_bounces": 64},
        {"light_fraction": 0.5, "direct_light": "MIXTURE"},
    ],
)
def test_settings_that_leave_the_expectation(settings: dict[str, object]) -> None:
    assert_equal_means(reference("room"), pictures(room(), SEEDS, samples=64, **settings))


@pytest.mark.parametrize("kind", ["diffuse_bounces", "glossy_bounces", "max_bounces"])
@pytest.mark.parametrize("limit", [0, 1])
def test_estimators_agree_under_limits(kind: str, limit: int) -> None:
    """The last surface before the light counts in none of them."""
    settings = {kind: limit, "samples": 64}
    mis = pictures(room(), SEEDS, **settings)
    if limit == 0:
        assert mis.mean() < 0.95 * reference("room").mean()
    for other in ({"direct_light": "LIGHT"}, {"direct_light": "BSDF"}, {"integrator": "BDPT"}):
        assert_equal_means(mis, pictures(room(), SEEDS, **settings, **other))


def test_bounce_limits_take_light_away_in_order() -> None:
    means = [
        picture(room(), samples=32, max_bounces=bounces).mean() for bounces in (0, 1, 2, 4, -1)
    ]
    assert all(np.diff(means) > 0)


def test_transparent_shadows_equal_their_share() -> None:
    """A sheet that passes 30 % of the light between lamp and floor."""
    clear = SceneBuilder((4, 4))
    clear.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.5))
    clear.light("AREA", transform=placed(1, (0, 0, 3)), emission=(50, 50, 50))
    camera = clear.camera((0, 0, 0.5), (0, 0, 0), kind="ORTHOGRAPHIC")
    camera.window = (-0.01, 0.01, -0.01, 0.01)
    open_sky = pictures(clear, SEEDS, samples=64)
    clear.add(
        quad((-3, -3, 1.5), (6, 0, 0), (0, 6, 0)),
        shader("ShaderNodeBsdfTransparent", Color=(0.3, 0.3, 0.3, 1)),
    )
    shaded = pictures(clear, SEEDS, samples=64)
    assert_equal_means(open_sky * 0.3, shaded)


def test_sum_of_passes_is_the_picture() -> None:
    from scenes import render

    names = [
        *(f"{kind} {part}" for kind in ("Diffuse", "Glossy", "Transmission")
          for part in ("Direct", "Indirect", "Color")),
        "Emission", "Environment",
    ]  # fmt: skip
    for build in SCENES.values():
        out = render(build(), ["Combined", *names], samples=16)
        total = out["Emission"] + out["Environment"]
        for kind in ("Diffuse", "Glossy", "Transmission"):
            light = out[f"{kind} Direct"] + out[f"{kind} Indirect"]
            total = total + light * out[f"{kind} Color"]
        assert total == pytest.approx(out["Combined"][..., :3], rel=2e-4, abs=1e-6)


def half_mirror_plane(strength: float) -> SceneBuilder:
    """Hughes' surface: 50 % matte and 30 % mirror."""
    scene = SceneBuilder((4, 4))
    graph = Graph(
        [
            Node("ShaderNodeBsdfDiffuse", inputs={"Color": (0.5, 0.5, 0.5, 1)}),
            Node("ShaderNodeBsdfAnisotropic",
                 inputs={"Color": (0.3, 0.3, 0.3, 1), "Roughness": 0.0}),
            Node("ShaderNodeAddShader", inputs={"Shader": Link(0, "BSDF"),
                                                "Shader_001": Link(1, "BSDF")}),
        ],
        Link(2, "Shader"),
    )  # fmt: skip
    scene.add(quad((-5, -5, 0), (10, 0, 0), (0, 10, 0)), graph)
    scene.description.world = background(strength)
    scene.camera((0, 0, 3), (0, 0, 0), fov=5)
    return scene


@pytest.mark.parametrize("direct_light", ["MIS", "LIGHT", "BSDF", "UNIFORM", "MIXTURE"])
def test_half_matte_and_three_tenths_mirror(direct_light: str) -> None:
    truth = 0.8 * 2.0
    shots = pictures(half_mirror_plane(2.0), SEEDS, samples=64, direct_light=direct_light)
    assert_mean_is(shots, truth)


def test_whitted_equals_path_tracing_of_direct_light() -> None:
    """With a point light and black surroundings there is nothing else."""
    scene = SceneBuilder((8, 8))
    scene.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.6))
    scene.add(box((-0.3, -0.3, 0.0), (0.3, 0.3, 0.6)), diffuse(0.8))
    scene.description.lights.append(
        Light("point", "POINT", placed(1, (1, -1, 2)), emission=(50,) * 3)
    )
    scene.camera((0, -4, 3), (0, 0, 0.3))
    a = picture(scene, samples=64, integrator="WHITTED")
    b = picture(scene, samples=64, max_bounces=0)
    assert a == pytest.approx(b, rel=1e-4)
