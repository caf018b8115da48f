"""Pictures whose every pixel is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from engine_core.description import Graph, Light, Link, Node
from scenes import (
    SceneBuilder,
    background,
    box,
    diffuse,
    emission,
    look_at,
    picture,
    pictures,
    placed,
    quad,
    shader,
    sphere,
)
from statistics_tools import assert_mean_is

SEEDS = 12


def floor_below_light(light: Light | None = None) -> SceneBuilder:
    """A white floor seen by an orthographic camera over its middle: 2 mm wide."""
    scene = SceneBuilder((4, 4))
    scene.add(quad((-5, -5, 0), (10, 0, 0), (0, 10, 0)), diffuse(1.0))
    camera = scene.camera((0, 0, 0.3), (0, 0, 0), kind="ORTHOGRAPHIC")
    camera.window = (-1e-3, 1e-3, -1e-3, 1e-3)
    if light is not None:
        scene.description.lights.append(light)
    return scene


def radiance_of_floor(irradiance: float) -> float:
    return irradiance / np.pi


@pytest.mark.parametrize("height", [0.5, 2.0])
def test_point_light(height: float) -> None:
    """E = P / (4 pi h^2)."""
    power = 30.0
    scene = floor_below_light(
        Light("point", "POINT", placed(1, (0, 0, height)), emission=(power,) * 3)
    )
    intensity = power / (4 * np.pi)
    expected = radiance_of_floor(intensity / height**2)
    assert picture(scene, samples=1) == pytest.approx(expected, rel=2e-4)


def test_spot_light_on_axis_equals_point_light() -> None:
    transform = placed(1, (0, 0, 2))
    spot = Light("spot", "SPOT", transform, emission=(20.0,) * 3, spot_angle=1.0, spot_blend=0.3)
    point = Light("point", "POINT", transform, emission=(20.0,) * 3)
    a = picture(floor_below_light(spot), samples=1)
    b = picture(floor_below_light(point), samples=1)
    assert a == pytest.approx(b, rel=1e-5)


def test_spot_light_is_dark_outside_its_cone() -> None:
    spot = Light(
        "spot", "SPOT", look_at((0, 0, 2), (5, 0, 2)), emission=(20.0,) * 3, spot_angle=1.0
    )
    assert picture(floor_below_light(spot), samples=1).max() == 0.0


@pytest.mark.parametrize("angle", [0.0, 0.009, 0.05, 0.5])
def test_sun(angle: float) -> None:
    """Irradiance W/m^2 on a surface that faces the sun, whatever its size."""
    sun = Light("sun", "SUN", placed(), emission=(3.0,) * 3, sun_angle=angle)
    shots = pictures(floor_below_light(sun), SEEDS, samples=64)
    # Few pixels' paths find the disk by chance, and then differ much: pixels are averaged.
    assert_mean_is(shots.mean(axis=(1, 2)), radiance_of_floor(3.0))


@pytest.mark.parametrize(("shape", "size"), [("RECTANGLE", (1.0, 2.0)), ("ELLIPSE", (1.5, 1.5))])
def test_area_light(shape: str, size: tuple[float, float]) -> None:
    """Form factors from a point to a parallel rectangle, and to a coaxial disk."""
    power, height = 10.0, 1.25
    light = Light(
        "area", "AREA", placed(1, (0, 0, height)), emission=(power,) * 3, shape=shape,
        size_x=size[0], size_y=size[1],
    )  # fmt: skip
    if shape == "RECTANGLE":
        area = size[0] * size[1]
        x, y = size[0] / 2 / height, size[1] / 2 / height
        a, b = np.sqrt(1 + x * x), np.sqrt(1 + y * y)
        factor = 4 / (2 * np.pi) * (x / a * np.arctan(y / a) + y / b * np.arctan(x / b))
    else:
        area = np.pi * (size[0] / 2) ** 2
        factor = (size[0] / 2) ** 2 / (height**2 + (size[0] / 2) ** 2)
    radiance = power / (np.pi * area)
    # The pixels see 1 mm around the middle: the form factor varies by less than 1e-4 there.
    expected = radiance_of_floor(np.pi * radiance * factor)
    assert_mean_is(pictures(floor_below_light(light), SEEDS, samples=64), expected, 2e-4)


def test_mesh_emitter_equals_form_factor() -> None:
    scene = floor_below_light()
    scene.add(quad((-0.5, 0.5, 1), (1, 0, 0), (0, -1, 0)), emission(4.0))
    x = 0.5
    a = np.sqrt(1 + x * x)
    factor = 4 / (2 * np.pi) * 2 * (x / a * np.arctan(x / a))
    assert_mean_is(pictures(scene, SEEDS, samples=64), 4.0 * factor, 2e-4)


@pytest.mark.parametrize("strength", [1.0, 1e-20, 1e20])
def test_constant_environment(strength: float) -> None:
    scene = floor_below_light()
    scene.description.world = background(strength)
    assert_mean_is(pictures(scene, SEEDS, samples=16) / strength, 1.0, 1e-5)


def test_closed_furnace() -> None:
    """Inside a closed emitter of albedo a the radiance is e / (1 - a) everywhere."""
    scene = SceneBuilder((6, 6))
    graph = Graph(
        [
            Node("ShaderNodeBsdfDiffuse", inputs={"Color": (0.5, 0.5, 0.5, 1.0)}),
            Node("ShaderNodeEmission", inputs={"Color": (1, 1, 1, 1), "Strength": 0.5}),
            Node("ShaderNodeAddShader", inputs={"Shader": Link(0, "BSDF"),
                                                "Shader_001": Link(1, "Emission")}),
        ],
        Link(2, "Shader"),
    )  # fmt: skip
    scene.add(box((-1, -1, -1), (1, 1, 1), inward=True), graph)
    scene.camera((0, 0, 0.5), (0.3, 0.2, -1), fov=90)
    assert_mean_is(pictures(scene, SEEDS, samples=64), 1.0)


@pytest.mark.parametrize("albedo", [0.2, 0.8])
def test_sphere_inside_an_emitter(albedo: float) -> None:
    """A convex matte body in a white world reflects its albedo."""
    scene = SceneBuilder((6, 6))
    scene.add(sphere(), diffuse(albedo))
    scene.description.world = background(1.0)
    scene.camera((0, 0, 5), (0, 0, 0), fov=10)
    # Roulette in a stratified pixel takes few values, far from normal: pixels are averaged.
    assert_mean_is(pictures(scene, SEEDS, samples=32).mean(axis=(1, 2)), albedo)


def test_fresnel_through_a_slab() -> None:
    """A glass plate at normal incidence passes (1-F)^2 / (1-F^2) of the light behind, both ways.

    With F the reflectance of one side, all interreflections summed, and radiance scaled back by
    the second refraction.
    """
    scene = SceneBuilder((2, 2))
    glass = shader("ShaderNodeBsdfGlass", Color=(1, 1, 1, 1), Roughness=0.0, IOR=1.5)
    scene.add(box((-5, -5, -0.1), (5, 5, 0.1)), glass)
    scene.add(quad((-5, -5, -1), (10, 0, 0), (0, 10, 0)), emission(2.0))
    scene.camera((0, 0, 3), (0, 0, 0), kind="ORTHOGRAPHIC").window = (-1e-3, 1e-3, -1e-3, 1e-3)
    one_side = ((1.5 - 1) / (1.5 + 1)) ** 2
    expected = 2.0 * (1 - one_side) ** 2 / (1 - one_side**2)
    assert_mean_is(pictures(scene, SEEDS, samples=256), expected)


def test_mirror_shows_the_light() -> None:
    scene = SceneBuilder((2, 2))
    mirror = shader("ShaderNodeBsdfAnisotropic", Color=(0.7, 0.7, 0.7, 1), Roughness=0.0)
    scene.add(quad((-5, -5, 0), (10, 0, 0), (0, 10, 0)), mirror)
    scene.description.world = background(2.0)
    scene.camera((0, 0, 3), (0, 0, 0), fov=5)
    assert picture(scene, samples=4) == pytest.approx(1.4, rel=1e-5)


@pytest.mark.parametrize("offset", [0.0, 1e4])
@pytest.mark.parametrize("scale", [1e-5, 1.0, 1e6])
def test_scale_and_place_change_nothing(scale: float, offset: float) -> None:
    """A closed box of albedo 0.9 in which the truth is 1, made small, large and far away."""
    scene = SceneBuilder((6, 6))
    graph = Graph(
        [
            Node("ShaderNodeBsdfDiffuse", inputs={"Color": (0.9, 0.9, 0.9, 1.0)}),
            Node("ShaderNodeEmission", inputs={"Color": (1, 1, 1, 1), "Strength": 0.1}),
            Node("ShaderNodeAddShader", inputs={"Shader": Link(0, "BSDF"),
                                                "Shader_001": Link(1, "Emission")}),
        ],
        Link(2, "Shader"),
    )  # fmt: skip
    at = np.array([offset * scale, -0.7 * offset * scale, 0.3 * offset * scale], np.float32)
    room = box((-1, -1, -1), (1, 1, 1), inward=True)
    room.positions = (room.positions * np.float32(scale) + at).astype(np.float32)
    scene.add(room, graph)
    eye = at + np.array([0.1, 0.2, 0.3], np.float32) * np.float32(scale)
    camera = scene.camera(eye, eye + np.array([1, 0.5, -1]) * max(scale, 1.0), fov=90)
    camera.clip_start = 1e-4 * scale
    camera.clip_end = 100 * scale
    assert_mean_is(pictures(scene, SEEDS, samples=64), 1.0, 1e-3)
