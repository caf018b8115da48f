"""Every path that the bidirectional tracer finds is made anew, and its bookkeeping compared.

`verify_paths` evaluates each vertex of a path again, from both sides, and computes the density of
every technique in the plain form. The sub-paths' densities, closures, throughputs and weights must
agree with that, and the weights of all techniques must sum to 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bidirectional_scenes import CAMERAS, EXTRAS, LIGHTS, MATERIALS, NOT_EMITTED, build, scaled
from scenes import SceneBuilder, box, diffuse, emission, quad

import engine_core
from engine_core import probe

TOLERANCE = 1e-4
SAMPLES = 12
#: Scenes whose lights reach some lobes only: their weights, as the path tracer's, do not sum to 1.
RESTRICTED = {"hidden_from_glossy"}


def verified(**names: Any) -> dict[str, Any]:
    """The report on a scene, by the balance and the power heuristic, with a pilot and without."""
    scene = engine_core.compile(build(**names).description, threads=2)
    assert not scene.warnings
    total: dict[str, Any] = {}
    for heuristic, pilot in (("BALANCE", False), ("POWER", True)):
        settings = {"integrator": "BDPT", "max_bounces": 7, "mis_heuristic": heuristic}
        report = probe.verify_paths(scene, settings, SAMPLES, TOLERANCE, pilot)
        assert report["non_finite"] == 0
        assert_agrees(report)
        total = report
    return total


def assert_agrees(
    report: dict[str, Any], in_corners: float = 0.005, least: int = 300, shortest: float = 1e-2
) -> None:
    paths = sum(report["techniques"].values())
    assert paths > least
    # The rims of lamps, by rounding.
    assert report["unseen"] <= 0.01 * (paths + sum(report["merges"].values()))
    # Both are sums in float64.
    for check in ("recursion", "sum"):
        count, failures, worst, path = report[check]
        assert failures == 0, (check, worst, path, count)
    # Sub-paths measure edges along their rays, which leave surfaces by the bound of rounding, and
    # the plain form between vertices: in corners edges are as short as a thousand times that.
    for check, share in (
        ("density", 0.05),
        ("scattering", 0.005),
        ("weight", in_corners),
        ("throughput", max(0.02, 10 * in_corners)),
    ):
        count, failures, worst, path = report[check]
        assert failures <= 2 + share * count, (check, failures, count, worst, path)
        assert worst < shortest, (check, worst, path, count)


@pytest.mark.parametrize("material", MATERIALS)
def test_materials(material: str) -> None:
    verified(material=material, light="many")


#: Matte, narrow, of both sides, beside a mirror, and such as no path from a light goes on from.
MERGED = ["diffuse", "near_mirror", "rough_glass", "principled_coat", "diffuse_and_mirror",
          "facing_clear", "light_path_diffuse"]  # fmt: skip


@pytest.mark.parametrize("connections", [0, 1])
@pytest.mark.parametrize("material", MERGED)
def test_merged_paths(material: str, connections: int) -> None:
    """The same where paths are merged too: a merge is judged as the path that it stands for."""
    scene = engine_core.compile(build(material, "many").description, threads=2)
    for heuristic, pilot in (("BALANCE", False), ("POWER", True)):
        settings = {"integrator": "VCM", "max_bounces": 7, "mis_heuristic": heuristic,
                    "vcm_connections": connections, "merge_radius": 1.0}  # fmt: skip
        report = probe.verify_paths(scene, settings, 4 * SAMPLES, TOLERANCE, pilot)
        assert report["non_finite"] == 0
        assert_agrees(report, least=300 if connections else 30)
        merges = sum(report["merges"].values())
        assert merges > 300
        assert report["uneven"] < 0.15 * merges


@pytest.mark.parametrize("material", MERGED)
def test_shared_light_paths(material: str) -> None:
    """The same where camera vertices are joined to vertices that are chosen by use."""
    scene = engine_core.compile(build(material, "many").description, threads=2)
    for heuristic in ("BALANCE", "POWER"):
        settings = {"integrator": "BDPT", "max_bounces": 7, "mis_heuristic": heuristic,
                    "share_light_paths": "ALWAYS"}  # fmt: skip
        report = probe.verify_paths(scene, settings, SAMPLES, TOLERANCE, True)
        assert report["non_finite"] == 0
        assert_agrees(report, shortest=3e-2)  # many times as many joins: some of shorter edges


def test_samples_without_light_paths() -> None:
    """Where paths from lights are of little use, not every sample has one: weights know it."""
    scene = engine_core.compile(build("diffuse", "world").description, threads=2)
    for heuristic in ("BALANCE", "POWER"):
        settings = {"integrator": "BDPT", "max_bounces": 7, "mis_heuristic": heuristic}
        report = probe.verify_paths(scene, settings, 3 * SAMPLES, TOLERANCE, True)
        assert report["own_paths"] < 1.0
        assert_agrees(report)


@pytest.mark.parametrize("light", LIGHTS)
def test_lights(light: str) -> None:
    report = verified(material="principled", light=light)
    assert {(1, 2), (1, 3)} <= set(report["techniques"])
    assert (report["weight"][0] == 0) == (light in RESTRICTED)


@pytest.mark.parametrize("view", CAMERAS)
def test_cameras(view: str) -> None:
    report = verified(material="fresnel", light="many", view=view)
    assert {(0, 3), (1, 2), (2, 1), (2, 2), (3, 2)} <= set(report["techniques"])


@pytest.mark.parametrize("extra", EXTRAS)
def test_hidden_and_transparent_surfaces(extra: str) -> None:
    verified(material="principled", light="many", extra=extra)


def test_long_paths_in_a_box_that_absorbs_nothing() -> None:
    """A hundred vertices: the products of their densities leave float64, their ratios do not."""
    scene = SceneBuilder((4, 4))
    scene.add(box((-1, -1, 0), (1, 1, 2), inward=True), diffuse(1.0))
    scene.add(quad((-0.2, 0.2, 1.9), (0.4, 0, 0), (0, -0.4, 0)), emission(5.0))
    scene.camera((0, -0.9, 1), (0, 0.5, 0.9), fov=70)
    compiled = engine_core.compile(scene.description, threads=1)
    settings = {"integrator": "BDPT", "max_bounces": 100}
    report = probe.verify_paths(compiled, settings, 1, TOLERANCE, False)
    assert max(s + t for s, t in report["techniques"]) >= 100
    assert_agrees(report, in_corners=0.1)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("material", ["principled", "glass", "near_mirror"])
def test_scales(scale: float, material: str) -> None:
    scene = engine_core.compile(scaled(build(material, "many"), scale).description, threads=2)
    settings = {"integrator": "BDPT", "max_bounces": 7}
    report = probe.verify_paths(scene, settings, SAMPLES, TOLERANCE, True)
    assert report["non_finite"] == 0
    assert_agrees(report)


@pytest.mark.parametrize("light", LIGHTS)
def test_densities_of_emitted_rays(light: str, rng: np.random.Generator) -> None:
    """A ray's own sample, and what is said of any such ray, are in one measure."""
    scene = engine_core.compile(build(light=light).description, threads=2)
    rows = rng.random((2000, 5), np.float32).tolist()
    own, any_ray = np.array(probe.emission_ray_densities(scene, rows)).T
    assert (own > 0).any() == (light not in NOT_EMITTED)
    # On the rims of cones and disks rounding decides whether a direction is within.
    agree = abs(own - any_ray) <= 1e-4 * own
    assert agree.mean() > 0.998
