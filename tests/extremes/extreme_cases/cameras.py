"""Fields of view from 0.01 to 179.9 degrees, lenses to f/0.001, cameras where none should be."""

from __future__ import annotations

from functools import partial

import numpy as np
from bidirectional_scenes import glass, graph
from scenes import SceneBuilder, background, emission, quad, sphere

from extreme_cases.case import Case, Finite, Needs, Same, Truth, power_of_ten
from extreme_cases.furnaces import after, furnace, unlimited


def wide(fov: float, size: tuple[int, int] = (4, 4)) -> SceneBuilder:
    """In the middle of the furnace."""
    scene = furnace(0.9, 0.1)
    scene.description.film.width, scene.description.film.height = size
    scene.description.film.crop = (0, 0, *size)
    scene.camera((0.1, -0.4, 0.05), (0.3, 0.5, 0.1), fov=fov)
    return scene


def lens(radius: float, focus: float, kind: str = "PERSPECTIVE") -> SceneBuilder:
    """A window into an even sky through a lens of any width: no focus changes what it sees."""
    scene = SceneBuilder((4, 4))
    scene.description.world = background(1.0)
    scene.camera((0, 0, 0), (0, 1, 0), kind=kind, aperture_radius=radius, focus_distance=focus)
    return scene


def focused(radius: float) -> SceneBuilder:
    """A wall of light in focus, at any opening as sharp as through a pinhole."""
    scene = SceneBuilder((8, 8))
    scene.add(quad((-9, 4, -9), (9, 0, 0), (0, 0, 18)), emission(1.0))
    scene.add(quad((0, 4, -9), (9, 0, 0), (0, 0, 18)), emission(0.25))
    scene.camera((0, 0, 0), (0, 1, 0), aperture_radius=radius, focus_distance=4.0)
    return scene


def in_glass(roughness: float) -> SceneBuilder:
    """Inside a ball of glass under an even sky."""
    scene = SceneBuilder((4, 4))
    scene.add(sphere(1.0, rings=16), graph(glass(roughness)))
    scene.description.world = background(1.0)
    scene.camera((0, -0.2, 0), (0, 0.5, 0.1), fov=60)
    return scene


def on_a_surface(above: float) -> SceneBuilder:
    """On the floor of the furnace, or that little above it."""
    scene = furnace(0.9, 0.1)
    scene.camera((0.1, -0.4, -1.0 + above), (0.3, 0.5, 0.1), fov=70, clip_start=1e-9)
    return scene


def far_away(distance: float) -> SceneBuilder:
    """A room's picture from `distance` times as far, through a lens that much longer."""
    scene = SceneBuilder((8, 8))
    scene.add(quad((-1, 0, -1), (1, 0, 0), (0, 0, 2)), emission(1.0))
    scene.add(quad((0, 0, -1), (1, 0, 0), (0, 0, 2)), emission(0.25))
    fov = 2 * np.degrees(np.arctan(1.0 / distance))
    scene.camera((0, -distance, 0), (0, 0, 0), fov=float(fov), clip_end=1e12)
    return scene


def cases() -> list[Case]:
    found = []
    truth = Truth(after(5, 0.9, 0.1))
    deep = unlimited(5)
    for fov in (0.01, 0.1, 1.0, 90.0, 170.0, 179.0, 179.9):
        found.append(
            Case("cameras", f"field of view of {power_of_ten(fov)} degrees", partial(wide, fov),
                 truth, Needs.ALL_LIGHT if 1 < fov < 170 else Needs.ALL_LIGHT | Needs.AIM, deep,
                 samples=4)
        )  # fmt: skip
    for kind in ("PERSPECTIVE", "ORTHOGRAPHIC"):
        for radius in (1e-8, 1.0, 1e3, 1e8):
            for focus in (1e-3, 10.0, 1e6):
                found.append(
                    Case("cameras",
                         f"{kind.lower()} lens of {power_of_ten(radius)}, in focus at "
                         f"{power_of_ten(focus)}",
                         partial(lens, radius, focus, kind), Truth(1.0, 1e-6), samples=4)
                )  # fmt: skip
    # f/0.001 at 50 mm is a radius of 25 m.
    for radius in (1e-6, 0.01, 1.0, 25.0):
        found.append(
            Case("cameras", f"wall in focus of a lens of {power_of_ten(radius)}",
                 partial(focused, radius), Same(partial(focused, 0.0)), samples=16)
        )  # fmt: skip
    found.append(
        Case("cameras", "inside glass", partial(in_glass, 0.0), Finite(), Needs.POLISHED,
             {"max_bounces": 100})
    )  # fmt: skip
    found.append(
        Case("cameras", "inside rough glass", partial(in_glass, 0.3),
             Same(partial(in_glass, 0.3), of_paths=True), Needs.POLISHED | Needs.ALL_LIGHT,
             {"max_bounces": 100})
    )  # fmt: skip
    for above in (0.0, 1e-7, 1e-5, 1e-3):
        found.append(
            Case("cameras", f"{power_of_ten(above)} above a floor", partial(on_a_surface, above),
                 truth if above else Finite(), Needs.ALL_LIGHT, deep, samples=4)
        )  # fmt: skip
    for distance in (1e2, 1e4, 1e6):
        found.append(
            Case("cameras", f"a picture {power_of_ten(distance)} times its size away",
                 partial(far_away, distance), Same(partial(far_away, 10.0), slack=1e-2))
        )  # fmt: skip
    for size in ((1, 1), (1, 7), (2048, 2), (2, 2048)):
        found.append(
            Case("cameras", f"{size[0]:,} by {size[1]:,} pixels", partial(wide, 70.0, size), truth,
                 Needs.ALL_LIGHT | (Needs.AIM if size[0] * size[1] > 16 else Needs.NOTHING), deep,
                 samples=16 if size == (1, 1) else 1, blurred=size[0] == 1)
        )  # fmt: skip
    found.append(
        Case("cameras", "16,384 by 2 pixels", partial(wide, 70.0, (16384, 2)), truth,
             Needs.ALL_LIGHT | Needs.AIM, deep, samples=1, large=True)
    )  # fmt: skip
    found.append(
        Case("cameras", "100,000 samples in one pixel", partial(wide, 70.0, (1, 1)), truth,
             Needs.ALL_LIGHT, deep, samples=100_000, large=True)
    )  # fmt: skip
    return found
