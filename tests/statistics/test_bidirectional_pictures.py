"""Bidirectional path tracing and light tracing make the path tracer's pictures."""

from __future__ import annotations

from functools import partial
from typing import Any

import pytest
from bidirectional_scenes import CAMERAS, EXTRAS, LIGHTS, MATERIALS, NOT_EMITTED, build
from method_pictures import Builder, MethodPictures
from scenes import SceneBuilder, box, diffuse, pictures, placed, quad
from statistics_tools import assert_equal_means

SEEDS = 8
SAMPLES = {"PATH": 128, "BDPT": 64, "LIGHT": 128}

#: Surfaces on which the camera sees what no light's path can show it.
SINGULAR = {"mirror", "glass", "diffuse_and_mirror", "fresnel_mirror", "facing_mirrors"}
#: Those that paths of lights do not enter, or whose lobes are too sharp for a few splats.
CAMERA_S_OWN = {"light_path_diffuse", "light_path_clear", "light_path_sheet", "camera_only",
                "near_mirror", "refraction", "backfacing_glass"}  # fmt: skip
#: Lamps within which surfaces lie: those see it from inside.
AROUND_SURFACES = {"point_soft_near", "point_hard_near"}

SCENES: dict[str, Builder] = {
    **{f"material {name}": partial(build, name, "many") for name in MATERIALS},
    **{f"light {name}": partial(build, "principled", name) for name in LIGHTS},
    **{f"camera {name}": partial(build, "fresnel", "many", name) for name in CAMERAS},
    **{f"extra {name}": partial(build, "principled", "many", "pinhole", name) for name in EXTRAS},
}


METHOD_PICTURES = MethodPictures(SCENES, SAMPLES, SEEDS)
shots, reference = METHOD_PICTURES.shots, METHOD_PICTURES.reference


@pytest.mark.parametrize("name", SCENES)
def test_bidirectional_path_tracing(name: str) -> None:
    assert_equal_means(reference(name), shots(name, "BDPT", max_bounces=5))


@pytest.mark.parametrize(
    "name",
    ["material rough_glass", "material diffuse_and_mirror", "light many", "camera focus"],
)
def test_shared_light_paths(name: str) -> None:
    shared = shots(name, "BDPT", max_bounces=5, share_light_paths="ALWAYS")
    assert_equal_means(reference(name), shared)


LIT_BY_PATHS = [
    name
    for name in SCENES
    if name.split()[1] not in SINGULAR | CAMERA_S_OWN | NOT_EMITTED | AROUND_SURFACES
]


@pytest.mark.parametrize("name", LIT_BY_PATHS)
def test_light_tracing(name: str) -> None:
    assert_equal_means(reference(name), shots(name, "LIGHT", max_bounces=5))


SETTINGS: dict[str, dict[str, Any]] = {
    "balance": {"mis_heuristic": "BALANCE"},
    "roulette late": {"roulette_start": 3},
    "roulette off": {"roulette_threshold": 0.0},
    "roulette early": {"roulette_threshold": 1.0},
}


@pytest.mark.parametrize("setting", SETTINGS)
def test_settings_leave_the_expectation(setting: str) -> None:
    name = "material rough_glass"
    assert_equal_means(reference(name), shots(name, "BDPT", max_bounces=5, **SETTINGS[setting]))


@pytest.mark.parametrize(
    "limits",
    [
        {"max_bounces": 0},
        {"max_bounces": 1},
        {"max_bounces": 2},
        {"max_bounces": 6, "transparent_bounces": 0},
    ],
)
@pytest.mark.parametrize("name", ["material half_clear", "material glass"])
def test_limits_on_all_bounces(name: str, limits: dict[str, int]) -> None:
    assert_equal_means(shots(name, "PATH", **limits), shots(name, "BDPT", **limits))


#: Mixed lobes, what both sides see otherwise, singular bounces, and what lets light through.
LIMITED_BY_KIND = {
    "material principled": {"diffuse_bounces": 1},
    "material principled_coat": {"glossy_bounces": 0, "diffuse_bounces": 1},
    "material rough_glass": {"transmission_bounces": 1, "diffuse_bounces": 1},
    "material diffuse_and_mirror": {"glossy_bounces": 0},
    "material diffuse_and_translucent": {"transmission_bounces": 0},
    "material facing": {"diffuse_bounces": 0, "glossy_bounces": 1},
}


@pytest.mark.parametrize("name", LIMITED_BY_KIND)
def test_limits_on_kinds_of_bounces(name: str) -> None:
    limits = {"max_bounces": 5, **LIMITED_BY_KIND[name]}
    limited = shots(name, "PATH", **limits)
    assert limited.mean() < 0.99 * reference(name).mean()
    assert_equal_means(limited, shots(name, "BDPT", **limits))
    if name in LIT_BY_PATHS:
        assert_equal_means(limited, shots(name, "LIGHT", **limits))


def test_limits_on_kinds_of_bounces_of_shared_light_paths() -> None:
    name = "material principled"
    limits = {"max_bounces": 5, **LIMITED_BY_KIND[name]}
    shared = shots(name, "BDPT", share_light_paths="ALWAYS", **limits)
    assert_equal_means(shots(name, "PATH", **limits), shared)


@pytest.mark.parametrize("integrator", ["LIGHT", "BDPT"])
@pytest.mark.parametrize("size", [1e3, 1e5])
def test_a_narrow_view_of_a_huge_plane_does_not_starve(integrator: str, size: float) -> None:
    """Paths from the sun are aimed at what the camera sees, and a lamp there has its share."""
    scene = SceneBuilder((16, 16))
    scene.add(quad((-size / 2, -size / 2, 0), (size, 0, 0), (0, size, 0)), diffuse(0.6))
    scene.add(box((-0.3, -0.3, 0.1), (0.3, 0.3, 0.5)), diffuse(0.7))
    scene.light("SUN", emission=(2.0,) * 3, sun_angle=0.01)
    scene.light("POINT", transform=placed(1.0, (0.6, -0.6, 1.0)), emission=(30.0,) * 3)
    scene.camera((0, -4, 3), (0, 0, 0.2), fov=20)
    path = pictures(scene, SEEDS, samples=64)
    other = pictures(scene, SEEDS, samples=64, integrator=integrator)
    assert_equal_means(path, other)
    # Of paths over the whole plane, not one of a million would come into view.
    assert other.std(axis=0, ddof=1).mean() < 0.5 * path.mean()
