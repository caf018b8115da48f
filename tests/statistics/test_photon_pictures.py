"""Photon methods make the path tracer's pictures, but for the blur of their radius.

The bias is bounded: light is gathered from an area about the point, and what lies beyond an edge
counts as dark. With radii of a part of a pixel little of that is left.
"""

from __future__ import annotations

from functools import cache
from math import prod
from typing import Any

import numpy as np
import pytest
from agreement import assert_agreement
from bidirectional_scenes import build
from scenes import SceneBuilder, diffuse, picture, pictures, placed, quad
from statistics_tools import Array

import engine_core
from engine_core import probe

SEEDS = 6
#: Relative: of the picture's mean, and of blocks of pixels.
BIAS, BLOCK_BIAS, POWER = 0.02, 0.10, 0.07
#: Materials that gather, that are followed and that do both, under every kind of lamp.
CASES = [
    ("diffuse", "many"),
    ("glossy", "point_soft"),
    ("mirror", "area"),
    ("rough_glass", "spot_hard"),
    ("glass", "sun_disk"),
    ("bump_diffuse", "area"),
    ("diffuse_and_mirror", "mesh"),
    ("diffuse_and_translucent", "sun"),
    ("principled_coat", "sky"),
    ("half_clear", "area_spread"),
]
#: Those in which the maps of a test of a second are not mere noise.
SMOOTH = [CASES[0], CASES[5], CASES[7], CASES[8]]
METHODS: dict[str, dict[str, Any]] = {
    "SPPM": {"samples": 24, "photon_radius": 0.3, "photon_paths": 8000, "photon_alpha": 1.0},
    "PHOTON": {"samples": 4, "global_photons": 10000, "caustic_photons": 5000,
               "photon_neighbours": 12, "photon_most_radius": 0.6},
}  # fmt: skip
PICTURES = [("SPPM", case) for case in CASES] + [("PHOTON", case) for case in SMOOTH]


@cache
def reference(material: str, light: str) -> Array:
    return pictures(build(material, light), SEEDS, integrator="BDPT", samples=64, max_bounces=5)


@pytest.mark.parametrize(("integrator", "case"), PICTURES)
def test_pictures(integrator: str, case: tuple[str, str]) -> None:
    shots = pictures(
        build(*case), SEEDS, integrator=integrator, max_bounces=5, **METHODS[integrator]
    )
    assert_agreement(reference(*case), shots, BIAS, block_tolerance=BLOCK_BIAS, power=POWER)


def test_final_gather() -> None:
    shots = pictures(
        build("diffuse", "many"), SEEDS, integrator="PHOTON", max_bounces=5, samples=6,
        global_photons=8000, caustic_photons=2000, final_gather_rays=8,
    )  # fmt: skip
    assert_agreement(
        reference("diffuse", "many"), shots, BIAS, block_tolerance=BLOCK_BIAS, power=POWER
    )


@pytest.mark.parametrize("integrator", METHODS)
def test_threads_do_not_matter(integrator: str) -> None:
    settings: dict[str, Any] = {"integrator": integrator, "samples": 3, "global_photons": 3000,
                                "caustic_photons": 3000}  # fmt: skip
    scene = build("glass", "many")
    one = picture(scene, threads=1, **settings)
    assert np.array_equal(one, picture(scene, threads=3, **settings))


@pytest.mark.parametrize(
    "settings",
    [
        {"integrator": "SPPM", "photon_paths": 1},
        {"integrator": "SPPM", "photon_radius": 0.01},
        {"integrator": "SPPM", "photon_radius": 1e6},
        {"integrator": "PHOTON", "global_photons": 1, "caustic_photons": 1},
        {"integrator": "PHOTON", "global_photons": 0, "caustic_photons": 0},
        {"integrator": "PHOTON", "global_photons": 100, "photon_neighbours": 1000,
         "photon_most_radius": 1e6, "caustic_photons": 2},
        {"integrator": "PHOTON", "photon_view": "GLOBAL", "global_photons": 3000},
        {"integrator": "PHOTON", "photon_view": "CAUSTIC", "caustic_photons": 3000},
    ],
)  # fmt: skip
def test_extremes_of_settings(settings: dict[str, Any]) -> None:
    """No photons, one, all for every point: finite, and something is seen."""
    shot = picture(build("glass", "many"), samples=2, **settings)
    assert np.isfinite(shot).all()
    assert shot.max() > 0.0


@pytest.mark.parametrize("integrator", METHODS)
def test_a_light_that_reaches_nothing(integrator: str) -> None:
    scene = SceneBuilder((8, 8))
    scene.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.5))
    scene.light("SUN", emission=(3.0, 3.0, 3.0))
    scene.description.lights[-1].transform[:3, :3] = np.diag([1.0, -1.0, -1.0])
    scene.camera((0, -4, 2), (0, 0, 0))
    shot = picture(scene, integrator=integrator, samples=1, global_photons=100)
    assert not shot.any()


def notes(scene: SceneBuilder, **settings: Any) -> str:
    compiled = engine_core.compile(scene.description, threads=1)
    return "\n".join(engine_core.Session(compiled, settings, ["Combined"]).notes)


def test_only_the_maps_that_the_scene_requires() -> None:
    matte, clear = build("diffuse", "area"), build("glass", "area")
    assert "No caustic map: nothing here is glossy" in notes(matte, integrator="PHOTON")
    assert notes(clear, integrator="PHOTON") == ""
    assert "No photon maps" in notes(clear, integrator="PHOTON", max_bounces=0)
    assert "No caustic map, as it is set" in notes(clear, integrator="PHOTON", caustic_photons=0)
    assert "limited in all" in notes(clear, integrator="SPPM", diffuse_bounces=2)


@pytest.mark.parametrize("alpha", [0.3, 2 / 3, 1.0])
def test_radius_shrinks_as_published(alpha: float) -> None:
    """Knaus and Zwicker 2011, equation 15."""
    for passes in (0, 1, 2, 10, 100):
        product = prod((i + alpha) / (i + 1) for i in range(1, passes + 1))
        assert probe.progressive_radius(passes, alpha) == pytest.approx(np.sqrt(product), rel=1e-6)


@pytest.mark.parametrize("integrator", METHODS)
def test_no_light_through_a_wall(integrator: str) -> None:
    """A lit sheet a hundredth of the radius above a floor: photons on it leave the floor dark."""
    scene = SceneBuilder((8, 8))
    scene.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.9))
    scene.add(quad((-3, -3, -0.001), (6, 0, 0), (0, 6, 0)), diffuse(0.9))
    scene.light("POINT", transform=placed(1.0, (0, 0, 1)), emission=(50.0, 50.0, 50.0))
    scene.camera((0, -0.5, -2), (0, 0, 0), fov=30)
    shot = picture(scene, integrator=integrator, samples=2, photon_direct="PHOTONS",
                   photon_radius=3.0, photon_paths=20000)  # fmt: skip
    assert not shot.any()
