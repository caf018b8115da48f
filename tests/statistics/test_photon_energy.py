"""Photons carry the lights' power: all of it is counted, and densities of it are radiance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bidirectional_scenes import build
from engine_core.description import Graph, Link, Node
from scenes import SceneBuilder, box, diffuse, look_at, pictures, quad, sphere
from statistics_tools import assert_mean_is

import engine_core
from engine_core import probe

ALBEDO = 0.6


def traced(scene: SceneBuilder, paths: int = 4096, seed: int = 1, **settings: Any) -> Any:
    compiled = engine_core.compile(scene.description, threads=1)
    return probe.trace_photons(compiled, settings, paths, seed)


@pytest.mark.parametrize("name", ["diffuse", "glass", "rough_glass", "principled", "half_clear"])
@pytest.mark.parametrize("light", ["many", "sun"])
def test_what_is_emitted_is_absorbed_or_escapes(name: str, light: str) -> None:
    counts = traced(build(name, light))
    assert counts["emitted"] > 0.0
    assert counts["absorbed"] + counts["escaped"] == pytest.approx(counts["emitted"], rel=1e-12)
    assert counts["escaped"] > 0.0
    assert counts["non_finite"] == 0


def closed_room(lamp: str = "POINT") -> SceneBuilder:
    scene = SceneBuilder((8, 8))
    scene.add(box((-1, -1, -1), (1, 1, 1), inward=True), diffuse(ALBEDO))
    at = look_at((0.1, 0.2, 0.3), (0.1, 0.2, -1.0))
    scene.light(lamp, transform=at, emission=(3.0, 3.0, 3.0))
    scene.camera((0.5, -0.9, 0.2), (0, 0.5, -0.6), fov=60)
    return scene


@pytest.mark.parametrize("lamp", ["POINT", "SPOT", "AREA"])
def test_power_is_that_of_the_lights(lamp: str) -> None:
    runs = [traced(closed_room(lamp), 1024, seed) for seed in range(8)]
    assert_mean_is(
        np.array([[run["emitted"] / run["paths"]] for run in runs]),
        runs[0]["total_power"],
        1e-5,
    )


def test_a_closed_room_keeps_its_light() -> None:
    """Nothing escapes, and what arrives is the geometric series of the albedo."""
    runs = [traced(closed_room(), 2048, seed) for seed in range(8)]
    assert all(run["escaped"] == 0.0 for run in runs)
    arrived = np.array([[run["arrived"] / run["emitted"]] for run in runs])
    assert_mean_is(arrived, 1.0 / (1.0 - ALBEDO))
    stored = np.array([[run["photons"][:, 3:6].mean(1).sum() / run["emitted"]] for run in runs])
    assert_mean_is(stored, 1.0 / (1.0 - ALBEDO))


def test_photons_keep_their_power() -> None:
    """Absorption is by chance: powers stay within a factor of each other."""
    powers = traced(closed_room())["photons"][:, 3]
    assert powers.min() > 0.99 * powers.max()


def test_limits_hold_for_photons() -> None:
    bounces = traced(closed_room(), max_bounces=3)["photons"][:, 7]
    assert bounces.max() == 3


def glowing() -> Graph:
    """Shines as much as it absorbs."""
    color = (ALBEDO, ALBEDO, ALBEDO, 1.0)
    nodes = [
        Node("ShaderNodeBsdfDiffuse", inputs={"Color": color}),
        Node("ShaderNodeEmission", inputs={"Strength": 1.0 - ALBEDO}),
        Node(
            "ShaderNodeAddShader",
            inputs={"Shader": Link(0, "BSDF"), "Shader_001": Link(1, "Emission")},
        ),
    ]
    return Graph(nodes, Link(2, "Shader"))


def furnace() -> SceneBuilder:
    """From inside of a glowing ball all looks alike."""
    scene = SceneBuilder((8, 8))
    scene.add(sphere(1.0, (0, 0, 0), rings=24), glowing())
    scene.camera((0.1, -0.2, 0.1), (0, 1, 0), fov=60)
    return scene


METHODS: dict[str, dict[str, Any]] = {
    "progressive": {"integrator": "SPPM", "photon_paths": 4000, "samples": 12},
    "photons alone": {"integrator": "SPPM", "photon_paths": 4000, "samples": 12,
                      "photon_direct": "PHOTONS"},
    "cone": {"integrator": "SPPM", "photon_paths": 4000, "samples": 12, "photon_kernel": "CONE"},
    "maps": {"integrator": "PHOTON", "global_photons": 4000, "samples": 8},
    "few neighbours": {"integrator": "PHOTON", "global_photons": 4000, "samples": 8,
                       "photon_neighbours": 5, "photon_kernel": "CONSTANT"},
    "maps alone": {"integrator": "PHOTON", "global_photons": 4000, "samples": 8,
                   "photon_direct": "PHOTONS"},
    "final gather": {"integrator": "PHOTON", "global_photons": 4000, "samples": 4,
                     "final_gather_rays": 4},
}  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
def test_white_furnace(method: str) -> None:
    """Radiance 1 everywhere; a hundredth is for the ball's curvature within the radius."""
    shots = pictures(furnace(), 6, **METHODS[method])
    assert_mean_is(shots.mean(axis=(1, 2, 3))[:, None], 1.0, 0.01)
    blocks = shots.reshape(6, 2, 4, 2, 4, 3).mean(axis=(2, 4, 5))
    assert_mean_is(blocks, 1.0, 0.02)


@pytest.mark.parametrize("integrator", ["SPPM", "PHOTON"])
def test_irradiance_under_a_disk(integrator: str) -> None:
    """On the axis of a disk lamp of radius r at height h: P / (pi (r^2 + h^2))."""
    radius, height, power = 0.8, 1.0, 10.0
    scene = SceneBuilder((8, 8))
    scene.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse(1.0))
    scene.light("AREA", transform=look_at((0, 0, height), (0, 0, 0), up=(0, 1, 0)),
                emission=(power,) * 3, shape="ELLIPSE", size_x=2 * radius,
                size_y=2 * radius)  # fmt: skip
    scene.camera((0, -0.02, 0.9), (0, 0, 0), fov=4)
    shots = pictures(scene, 6, integrator=integrator, samples=6, photon_direct="PHOTONS",
                     photon_paths=20000, global_photons=20000, photon_radius=12.0,
                     photon_most_radius=100.0)  # fmt: skip
    irradiance = power / (np.pi * (radius**2 + height**2))
    assert_mean_is(shots.mean(axis=(1, 2)), irradiance / np.pi, 0.005)
