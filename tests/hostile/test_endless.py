"""What would go on for ever ends: by the time limit, or when it is cancelled.

All loops of the core but two kinds run over something finite: arrays, the bits of a number, the
bounces that 16 bits count. The two are chains and the walks of paths, which ask at every step
whether the render is to end, and waits for other threads, which are told.
"""

from __future__ import annotations

import time
from typing import Any

import pytest
from bidirectional_scenes import lamp
from scenes import SceneBuilder, box, diffuse, shader

import engine_core

INTEGRATORS = [
    identifier
    for parameter in engine_core.parameters()
    if parameter.name == "integrator"
    for identifier, *_ in parameter.items
]
#: Nothing absorbs, nothing ends a path but the most bounces that can be counted.
ENDLESS = {"max_bounces": 1 << 16, "transparent_bounces": 1 << 16, "roulette_threshold": 0.0,
           "whitted_depth": 64, "samples": 1 << 24}  # fmt: skip


def closed_room(clear: bool, albedo: float = 1.0) -> SceneBuilder:
    """A closed room that returns all light or a part, with a box of white glass about the camera or
    not."""
    scene = SceneBuilder((8, 8))
    scene.add(box((-1, -1, -1), (1, 1, 1), inward=True), diffuse(albedo))
    if clear:
        glass = shader("ShaderNodeBsdfGlass", Color=(1.0, 1.0, 1.0, 1.0), Roughness=0.0, IOR=1.5)
        scene.add(box((-0.9, -0.9, -0.9), (0.9, 0.9, 0.9)), glass)
    lamp("POINT", scene, at=(0, 0, 0.5), radius=0.1)
    scene.camera((0.1, -0.4, 0.05), (0.3, 0.5, 0.1), fov=70)
    return scene


def check_end(scene: SceneBuilder, settings: dict[str, Any], cancel_after: float = 0.0) -> None:
    """Renders, and cancels after some seconds if these are not 0: it ends, without an error."""
    session = engine_core.Session(
        engine_core.compile(scene.description, threads=2), {"threads": 2, **settings}, ["Combined"]
    )
    session.start()
    if cancel_after > 0.0:
        time.sleep(cancel_after)
        session.cancel()
    assert session.wait(60.0), "it goes on and on"
    assert session.error_message == ""


@pytest.mark.parametrize("clear", [False, True], ids=["matte", "glass"])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_time_limit_ends_what_has_no_end(integrator: str, clear: bool) -> None:
    check_end(closed_room(clear), {**ENDLESS, "integrator": integrator, "time_limit": 0.05})


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_cancelling_ends_what_has_no_end(integrator: str) -> None:
    check_end(closed_room(False), {**ENDLESS, "integrator": integrator}, cancel_after=0.02)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_what_no_light_leaves_is_left(integrator: str) -> None:
    """By the samples, where bounces are not limited: most of what the camera sees from within the
    clear box is reflected in it for ever."""
    photons = {"global_photons": 1000, "caustic_photons": 1000}
    check_end(closed_room(True, 0.3), {"integrator": integrator, "samples": 4, **photons})
