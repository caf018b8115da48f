"""Lights without extent and of 1e-8 to 1e8 units, suns of 0 and 180 degrees, one pixel of 1e9."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from bidirectional_scenes import lamp, room
from engine_core.description import Graph, Image, Link, Node, World
from scenes import SceneBuilder, placed

from extreme_cases.case import Case, Finite, Needs, Same, power_of_ten


def lit(kind: str, scale: float = 1.0, **fields: object) -> SceneBuilder:
    """One lamp; `scale` multiplies its emission."""
    scene = room()
    lamp(kind, scene, emission=(60.0 * scale, 50.0 * scale, 40.0 * scale), **fields)
    return scene


def sky(value: float) -> SceneBuilder:
    """An image with one bright pixel."""
    scene = room()
    pixels = np.full((64, 128, 3), 0.2, np.float32)
    pixels[50, 30] = value
    scene.description.images.append(Image("sky", pixels, "linear"))
    nodes = [
        Node("ShaderNodeTexCoord"),
        Node("ShaderNodeTexEnvironment", inputs={"Vector": Link(0, "Generated")},
             params={"image": 0}),
        Node("ShaderNodeBackground", inputs={"Color": Link(1, "Color"), "Strength": 1.0}),
    ]  # fmt: skip
    scene.description.world = World(Graph(nodes, Link(2, "Background")))
    return scene


def lamps(count: int) -> SceneBuilder:
    """A cloud of equal lamps over the room."""
    scene = room()
    places = np.random.default_rng(7).uniform((-2, -2, 2.5), (2, 2, 4), (count, 3))
    power = 200.0 / count
    for at in places:
        scene.light("POINT", transform=placed(1.0, at), emission=(power,) * 3)
    return scene


def cases() -> list[Case]:
    found = []
    four: dict[str, object] = {"max_bounces": 4}
    soft = Needs.SOFT_LIGHT | Needs.ALL_LIGHT
    kinds: dict[str, tuple[str, dict[str, object]]] = {
        "point": ("POINT", {}),
        "hard point": ("POINT", {"soft_falloff": False}),
        "spot": ("SPOT", {"spot_angle": 1.2}),
    }
    for title, (kind, fields) in kinds.items():
        none = partial(lit, kind, radius=0.0, **fields)
        for radius in (0.0, 1e-8, 1e-6, 1e-4, 1e-3):
            found.append(
                Case("lights", f"{title} of radius {power_of_ten(radius)}",
                     partial(lit, kind, radius=radius, **fields),
                     Same(none, slack=2e-3), settings=four)
            )  # fmt: skip
        for radius in (0.5, 1e2, 1e4, 1e8):
            build = partial(lit, kind, radius**2, radius=radius, **fields)
            inside = radius > 1.0
            found.append(
                Case("lights", f"{title} of radius {power_of_ten(radius)}", build,
                     Finite() if inside else Same(build, of_paths=True), soft, four)
            )  # fmt: skip
    for shape in ("RECTANGLE", "ELLIPSE"):
        name = shape.lower()
        for size in (1e-8, 1e-6, 1e-4):
            found.append(
                Case("lights", f"{name} of side {power_of_ten(size)}",
                     partial(lit, "AREA", shape=shape, size_x=size, size_y=size),
                     Same(partial(lit, "AREA", shape=shape, size_x=1e-3, size_y=1e-3), slack=2e-3),
                     settings=four)
            )  # fmt: skip
        for size in (1.0, 1e2, 1e4, 1e8):
            build = partial(lit, "AREA", size**2, shape=shape, size_x=size, size_y=size)
            found.append(
                Case("lights", f"{name} of side {power_of_ten(size)}", build,
                     Same(build, of_paths=True), soft if size <= 1 else soft | Needs.AIM, four)
            )  # fmt: skip
        thin = partial(lit, "AREA", shape=shape, size_x=1e-7, size_y=2.0)
        found.append(
            Case("lights", f"{name} of 1e-7 by 2", thin, Same(thin, of_paths=True), soft, four)
        )
        for spread in (0.0, 1e-4, 3.14159265):
            build = partial(lit, "AREA", shape=shape, size_x=0.8, size_y=0.8, spread=spread)
            found.append(
                Case("lights", f"{name} of spread {power_of_ten(spread)}", build,
                     Same(build, of_paths=True), soft, four)
            )  # fmt: skip
    for angle in (1e-6, 1e-4):
        found.append(
            Case("lights", f"sun of {power_of_ten(angle)} radians",
                 partial(lit, "SUN", 0.05, sun_angle=angle),
                 Same(partial(lit, "SUN", 0.05, sun_angle=0.0), slack=2e-3), settings=four)
        )  # fmt: skip
    for angle in (0.0, 0.5, 3.0, np.pi):
        build = partial(lit, "SUN", 0.05, sun_angle=float(angle))
        found.append(
            Case("lights", f"sun of {np.degrees(angle):.0f} degrees", build,
                 Same(build, of_paths=True), soft, four)
        )  # fmt: skip
    for value in (1e3, 1e6, 1e9):
        found.append(
            Case("lights", f"sky with one pixel of {power_of_ten(value)}", partial(sky, value),
                 Same(partial(sky, value), of_paths=True), soft, four)
        )  # fmt: skip
    for count in (1000, 100_000):
        found.append(
            Case("lights", f"{count:,} lamps", partial(lamps, count),
                 Same(partial(lamps, count), of_paths=True), soft, {"max_bounces": 1},
                 large=count > 1000)
        )  # fmt: skip
    return [replace(case, blurred=True) for case in found]
