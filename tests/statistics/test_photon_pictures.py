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
from bidirectional_scenes import MATERIALS, build, constant_mix, glossy, matte
from scenes import SceneBuilder, background, diffuse, picture, pictures, placed, quad
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


def test_all_photons_in_one_point() -> None:
    """A beam of a thousandth of a degree: progressive mapping keeps its power, and nearest photons
    that leave no area are finite."""
    scene = SceneBuilder((16, 16))
    scene.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.5))
    scene.light("SPOT", transform=placed(1.0, (0.03, 0.02, 1e-3)), emission=(9.0, 9.0, 9.0),
                spot_angle=2e-5)  # fmt: skip
    scene.camera((0, -1e-3, 4), (0, 0, 0), fov=90, kind="ORTHOGRAPHIC")
    compiled = engine_core.compile(scene.description, threads=1)
    traced = probe.trace_photons(compiled, {}, 1000, 1)
    places = traced["photons"][:, :3]
    assert len(places) == 1000
    assert np.ptp(places, axis=0).max() < 1e-7
    seen = 0.5 / np.pi * traced["emitted"] / traced["paths"] / 2.0**2
    options = {"photon_direct": "PHOTONS", "max_bounces": 1, "global_photons": 1000}
    shot = picture(scene, integrator="SPPM", samples=64, photon_alpha=1.0, **options)
    assert shot.mean() == pytest.approx(seen, rel=0.05)
    for kernel in ("EPANECHNIKOV", "CONE", "CONSTANT"):
        shot = picture(scene, integrator="PHOTON", samples=4, photon_kernel=kernel, **options)
        assert np.isfinite(shot).all()
        assert (shot >= 0).all()


@pytest.mark.parametrize("integrator", METHODS)
def test_what_a_floor_reflects_is_there_in_every_sample(integrator: str) -> None:
    scene = SceneBuilder((8, 8))
    floor = constant_mix(0.2, matte((0.0, 0.0, 0.0)), glossy(0.0, (1.0, 1.0, 1.0)))
    scene.add(quad((-9, -9, 0), (18, 0, 0), (0, 18, 0)), floor)
    scene.description.world = background(1.0)
    scene.camera((0, -3, 3), (0, 0, 0))
    shot = picture(scene, integrator=integrator, samples=1, global_photons=10, caustic_photons=10)
    assert shot == pytest.approx(0.2, rel=1e-5)


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


def notes_of_render(scene: SceneBuilder, **settings: Any) -> str:
    compiled = engine_core.compile(scene.description, threads=2)
    session = engine_core.Session(compiled, {"samples": 1, **settings}, ["Combined"])
    session.start()
    while not session.wait(60.0):
        pass
    assert not session.error_message
    return "\n".join(session.notes)


def test_maps_that_pilots_find_no_photons_for() -> None:
    """What no path of the pilot finds, and what would take too many, is told."""
    behind = build("glass", "area")
    behind.description.lights[-1].transform[:3, :3] = np.diag([1.0, -1.0, -1.0])
    told = notes_of_render(behind, integrator="PHOTON", max_bounces=2, global_photons=100)
    assert "No caustic map: none of" in told
    # A mirror that sends nearly all of the light past a small matte square.
    scene = SceneBuilder((4, 4))
    scene.add(quad((-1, -1, 0), (2, 0, 0), (0, 2, 0)), MATERIALS["mirror"])
    scene.add(quad((3, 0, 3), (0.03, 0, 0), (0, 0.03, 0)), diffuse(0.5))
    scene.light("POINT", transform=placed(1.0, (0, 0, 1)), emission=(9.0, 9.0, 9.0))
    scene.camera((0, -4, 2), (0, 0, 0))
    told = notes_of_render(scene, integrator="PHOTON", caustic_photons=1000)
    assert "The caustic map will hold about" in told
    assert "of 1000 photons" in told


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
