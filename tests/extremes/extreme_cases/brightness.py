"""Emission from 1e-30 to 1e30, alone and in one frame: the picture is in proportion to it."""

from __future__ import annotations

from functools import partial

from bidirectional_scenes import lamp, panel, room
from scenes import SceneBuilder, background, emission, quad

from extreme_cases.case import Case, Finite, Same, Truth, power_of_ten


def shining(strength: float) -> SceneBuilder:
    scene = room()
    panel(emission(12.0 * strength), scene)
    lamp("POINT", scene, radius=0.1, emission=(40.0 * strength,) * 3)
    scene.description.world = background(0.3 * strength)
    return scene


def in_one_frame(ratio: float) -> SceneBuilder:
    """One wall is brighter than another by `ratio` squared."""
    scene = room()
    scene.add(quad((-2, -2, 0), (0, 4, 0), (0, 0, 3)), emission(1.0 / ratio))
    scene.add(quad((2, -2, 0), (0, 4, 0), (0, 0, 3)), emission(ratio))
    return scene


def seen(strength: float) -> SceneBuilder:
    """A wall of light and nothing else."""
    scene = SceneBuilder((4, 4))
    scene.add(quad((-9, 1, -9), (18, 0, 0), (0, 0, 18)), emission(strength))
    scene.camera((0, 0, 0), (0, 1, 0))
    return scene


def cases() -> list[Case]:
    found = []
    four: dict[str, object] = {"max_bounces": 4}
    for power in (-30, -25, -20, -15, -10, -5, 5, 10, 15, 20, 25, 30):
        strength = 10.0**power
        name = power_of_ten(strength)
        found.append(
            Case("brightness", f"lights times {name}", partial(shining, strength),
                 Same(partial(shining, 1.0), strength), settings=four)
        )  # fmt: skip
        found.append(
            Case("brightness", f"a wall of {name} seen", partial(seen, strength),
                 Truth(strength, 1e-6), samples=4)
        )  # fmt: skip
    for power in (5, 15, 30):
        found.append(
            Case("brightness", f"1e-{power} and 1e{power} in one frame",
                 partial(in_one_frame, 10.0**power), Finite(), settings=four)
        )  # fmt: skip
    return found
