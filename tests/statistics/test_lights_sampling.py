"""Light samples against the density that rays give for the same directions."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from engine_core.description import Graph, Image, Link, Node, World
from light_probes import (
    assert_samples_follow_density,
    compiled,
    frame,
    met,
    receiver,
    sample,
    unit,
)
from scenes import SceneBuilder, background, emission, look_at, mesh, placed

from engine_core import probe

Vector = tuple[float, float, float]
UP: Vector = (0, 0, 1)


def scene_with(kind: str, **fields: object) -> SceneBuilder:
    builder = SceneBuilder()
    builder.light(kind, **{"emission": (3.0, 2.0, 1.0), **fields})
    return builder


def triangle(a: Vector, b: Vector, c: Vector, strength: float = 2.0) -> SceneBuilder:
    builder = SceneBuilder()
    builder.add(mesh("triangle", [a, b, c], [(0, 1, 2)]), emission(strength))
    return builder


def point(radius: float, soft: bool, at: Vector = (0, 0, 0)) -> SceneBuilder:
    return scene_with("POINT", radius=radius, soft_falloff=soft, transform=placed(1.0, at))


def spot(radius: float, soft: bool, angle: float, scale: Vector = (1, 1, 1)) -> SceneBuilder:
    linear = np.diag(scale)
    return scene_with(
        "SPOT",
        radius=radius,
        soft_falloff=soft,
        spot_angle=np.radians(angle),
        spot_blend=0.4,
        transform=placed(linear, (0, 0, 3)),
    )


def area(
    shape: str, spread: float, sizes: tuple[float, float] = (2.0, 1.0), shear: float = 0.0
) -> SceneBuilder:
    linear = np.array([[1, shear, 0], [0, 1, 0], [0, 0, 1]], float)
    return scene_with(
        "AREA",
        shape=shape,
        size_x=sizes[0],
        size_y=sizes[1],
        spread=np.radians(spread),
        transform=placed(linear, (0, 0, 2)),
    )


def sun(angle: float) -> SceneBuilder:
    return scene_with("SUN", sun_angle=np.radians(angle), transform=look_at((1, 2, 3), (0, 0, 0)))


# A scene, the receiver's place and its normal.
CASES: dict[str, tuple[Callable[[], SceneBuilder], Vector, Vector]] = {
    "sphere, far": (lambda: point(0.5, False), (0, 0, -40), UP),
    "sphere, near": (lambda: point(1.0, False), (0, 0.3, -1.02), UP),
    "sphere, very far": (lambda: point(0.1, False), (300, 100, -200), UP),
    "disk, far": (lambda: point(0.5, True), (1, 2, -9), UP),
    "disk, within its radius": (lambda: point(1.0, True), (0.1, 0.2, -0.3), UP),
    "spot sphere, cone narrower than lamp": (lambda: spot(1.0, False, 25), (0.2, 0, 1.5), UP),
    "spot sphere, lamp narrower than cone": (lambda: spot(0.2, False, 80), (0.4, 0.3, 0), UP),
    "spot disk, scaled": (lambda: spot(0.5, True, 50, (2, 1, 1)), (0.9, 0, 0.5), UP),
    "spot disk, cone narrower than lamp": (lambda: spot(2.0, True, 20), (0.1, 0, 2.0), UP),
    "rectangle, near": (lambda: area("RECTANGLE", 180), (0.3, 0.2, 1.8), UP),
    "rectangle, far": (lambda: area("RECTANGLE", 180), (5, 9, -80), UP),
    "rectangle, grazing": (lambda: area("RECTANGLE", 180), (4, 1, 1.9), UP),
    "rectangle, spread, clipped": (lambda: area("RECTANGLE", 60), (0.9, 0.2, 1.2), UP),
    "rectangle, spread, small": (lambda: area("RECTANGLE", 20), (0.2, 0.1, 0.5), UP),
    "rectangle, sheared": (lambda: area("RECTANGLE", 180, (2, 1), 0.6), (0.2, 0.1, 0.9), UP),
    "strip, close": (lambda: area("RECTANGLE", 180, (8.0, 0.05)), (1, 0.2, 1.9), UP),
    "ellipse, near": (lambda: area("ELLIPSE", 180), (0.3, 0.2, 1.7), UP),
    "ellipse, far": (lambda: area("ELLIPSE", 180), (2, 3, -30), UP),
    "ellipse, spread": (lambda: area("ELLIPSE", 90), (0.9, 0.2, 1.5), UP),
    "disk lamp, spread within it": (lambda: area("ELLIPSE", 30, (3, 3)), (0.2, 0.1, 0.5), UP),
    "sun": (lambda: sun(5), (0, 0, 0), UP),
    "wide sun": (lambda: sun(170), (0, 0, 0), UP),
    "triangle, near": (
        lambda: triangle((-1, -1, 1), (1, -1, 1.5), (0, 1, 1)),
        (0.1, 0.1, 0.5),
        UP,
    ),
    "triangle, behind": (
        lambda: triangle((-1, -1, 1), (1, -1, 1.5), (0, 1, 1)),
        (0.1, 0.1, 3),
        (0, 0, -1),
    ),
    "triangle, far": (lambda: triangle((-1, -1, 1), (1, -1, 1), (0, 1, 1)), (9, 2, -30), UP),
    "triangle, grazing": (lambda: triangle((-1, -1, 1), (1, -1, 1), (0, 1, 1)), (1, 2, 0.9), UP),
    "triangle, sliver": (lambda: triangle((-5, 0, 1), (5, 0, 1), (5, 0.01, 1)), (1, 1, 0.4), UP),
    "triangle, blunt sliver": (
        lambda: triangle((-5, 0, 1), (5, 0, 1), (1, 0.02, 1)),
        (1, 1, 0.4),
        UP,
    ),
}
# Lights that fill a small part of any cone.
THIN = {"rectangle, grazing", "strip, close", "triangle, grazing", "triangle, sliver"} | {
    "triangle, blunt sliver"
}


@pytest.mark.parametrize("name", CASES)
def test_directions_follow_the_density(name: str, rng: np.random.Generator) -> None:
    make, p, n = CASES[name]
    scene = compiled(make())
    s = assert_samples_follow_density(scene, receiver(p, n), rng, thin=name in THIN)
    # The ray that goes along a sample meets the same light at the same place. Rays along the rim
    # may miss it by rounding.
    hits, radiance, pdf = met(scene, receiver(p, n), s.wi[s.valid])
    assert (hits == 1).mean() > 0.995
    hit = hits == 1
    assert pdf[hit] == pytest.approx(s.pdf[s.valid][hit], rel=3e-3)
    assert radiance[hit] == pytest.approx(s.radiance[s.valid][hit, 0], rel=3e-3, abs=1e-3)
    from_record = probe.light_pdf(
        scene,
        receiver(p, n),
        s.light[s.valid],
        np.concatenate([s.wi, s.distance[:, None], s.n], axis=1)[s.valid].astype(np.float32),
    )
    assert from_record[:, 0] == pytest.approx(s.pdf[s.valid], rel=2e-3)
    assert not s.delta.any()
    assert s.hittable[s.valid].all()


@pytest.mark.parametrize("angle", [2e-5, 1e-3, 0.0092, 0.5, 3.1])
@pytest.mark.parametrize("toward", [(0, 0, -3), (1, 2, -3)])
def test_a_sun_is_met_where_it_is_sampled(
    angle: float, toward: Vector, rng: np.random.Generator
) -> None:
    """Directions have 24 bits: no more of the disk's rim may be in doubt than they leave."""
    transform, count = look_at((0, 0, 0), toward), 1 << 18
    scene = compiled(scene_with("SUN", sun_angle=angle, transform=transform))
    axis = unit(np.asarray(transform, np.float64)[:, 2])
    at = receiver((0, 0, 0), axis)
    # A shift of d of the rim is a share 2 d of the disk over its half angle.
    doubt = 2 * 4 * 2.0**-24 / (angle / 2)
    outside = met(scene, at, sample(scene, at, rng, count).wi)[0] == 0
    assert outside.sum() <= doubt * count
    # Directions spread evenly over a cone somewhat larger, in float64.
    height = 2 * math.sin(angle / 4) ** 2
    h, phi = 1.1 * height * rng.random(count), 2 * np.pi * rng.random(count)
    r = np.sqrt(h * (2 - h))
    d = np.stack([r * np.cos(phi), r * np.sin(phi), 1 - h], axis=-1) @ frame(axis)
    wrong = (met(scene, at, d)[0] == 1) != (h <= height)
    assert wrong.sum() <= doubt * count


@pytest.mark.parametrize("transmits", [False, True])
@pytest.mark.parametrize("kind", ["sphere from inside", "uniform world"])
def test_all_around(kind: str, transmits: bool, rng: np.random.Generator) -> None:
    builder = point(2.0, False) if kind == "sphere from inside" else SceneBuilder()
    if kind == "uniform world":
        builder.description.world = background(2.0)
    at = receiver((0.5, 0.2, 0.1), (1, 2, 3), transmits=transmits)
    assert_samples_follow_density(compiled(builder), at, rng)


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "SUN", "AREA"])
def test_lights_without_size_are_deltas(kind: str, rng: np.random.Generator) -> None:
    builder = scene_with(
        kind, radius=0.0, sun_angle=0.0, spread=0.0, transform=placed(1, (0, 0, 3))
    )
    scene = compiled(builder)
    at = receiver((0.1, 0.2, 0))
    s = sample(scene, at, rng, 100)
    assert s.valid.all()
    assert s.delta.all()
    assert not s.hittable.any()
    assert (s.pdf == 1).all()
    # No ray finds it.
    assert not met(scene, at, s.wi)[0].any()


def test_without_multiple_importance_rays_do_not_meet_lamps(rng: np.random.Generator) -> None:
    scene = compiled(scene_with("AREA", use_mis=False, transform=placed(1, (0, 0, 2))))
    s = sample(scene, receiver((0, 0, 0)), rng, 100)
    assert s.valid.all()
    assert not s.hittable.any()
    assert not met(scene, receiver((0, 0, 0)), s.wi)[0].any()
    # Cameras see it all the same (visibility permitting).
    d = np.array([[0, 0, 1]], np.float32)
    assert not probe.meet_lights(scene, receiver((0, 0, 0)), d, 1)[0, 0]
    seen = compiled(
        scene_with("AREA", use_mis=False, visibility=31, transform=placed(1, (0, 0, 2)))
    )
    assert probe.meet_lights(seen, receiver((0, 0, 0)), d, 1)[0, 0]


def test_dark_sides_are_not_sampled(rng: np.random.Generator) -> None:
    for make, p in [
        (lambda: area("RECTANGLE", 180), (0, 0, 2.5)),  # behind
        (lambda: area("RECTANGLE", 180), (0, 0, 2.0)),  # in its plane
        (lambda: area("RECTANGLE", 30), (4, 0, 1.8)),  # beside the spread
        (lambda: spot(0.1, False, 30), (3, 0, 2.9)),  # beside the cone
    ]:
        assert not sample(compiled(make()), receiver(p), rng, 200).valid.any()


def pictured(kind: str, vector: str) -> Graph:
    """A shader whose colour is image 0 by an output of the texture coordinates."""
    texture = {"ShaderNodeBackground": "ShaderNodeTexEnvironment"}.get(kind, "ShaderNodeTexImage")
    output = {"ShaderNodeBackground": "Background"}.get(kind, "Emission")
    return Graph(
        [
            Node("ShaderNodeTexCoord"),
            Node(
                texture,
                inputs={"Vector": Link(0, vector)},
                params={"image": 0, "interpolation": "Linear", "projection": "EQUIRECTANGULAR"}
                if texture == "ShaderNodeTexEnvironment"
                else {"image": 0, "interpolation": "Linear"},
            ),
            Node(kind, inputs={"Color": Link(1, "Color"), "Strength": 2.0}),
        ],
        Link(2, output),
    )


def dim_sky_with_a_bright_spot() -> Any:
    builder = SceneBuilder()
    pixels = np.full((32, 64, 3), 0.1, np.float32)
    pixels[22:24, 40:43] = (90, 60, 30)
    builder.description.images = [Image("sky", pixels, "linear")]
    builder.description.world = World(pictured("ShaderNodeBackground", "Generated"))
    return compiled(builder)


def test_a_world_with_an_image(rng: np.random.Generator) -> None:
    """Its map is followed, and its light adds up."""
    scene = dim_sky_with_a_bright_spot()
    at = receiver((0, 0, 0), (0.2, 0.1, 1.0))
    s = assert_samples_follow_density(scene, at, rng, fine=64)
    value = np.where(s.valid, s.radiance[:, 0] / np.maximum(s.pdf, 1e-30), 0)
    d = unit(rng.normal(size=(400_000, 3)))
    uniform = met(scene, at, d)[1] * 4 * np.pi
    error = np.hypot(value.std() / np.sqrt(len(value)), uniform.std() / np.sqrt(len(uniform)))
    assert abs(value.mean() - uniform.mean()) < 4.5 * error
    assert value.std() < 0.5 * value.mean()  # the radiance is followed closely


def test_the_peaks_of_a_world_with_an_image(rng: np.random.Generator) -> None:
    """Where other directions find the sky as well, light sampling finds the bright spot alone."""
    scene = dim_sky_with_a_bright_spot()
    at = np.append(receiver((0, 0, 0)), np.float32([[1]]), axis=1)
    s = assert_samples_follow_density(scene, at, rng, fine=64)
    assert (s.radiance[s.valid, 0] > 0.3).mean() > 0.99
    d = unit(rng.normal(size=(10_000, 3)))
    _, radiance, pdf = met(scene, at, d)
    assert (pdf[radiance < 0.21] == 0).mean() > 0.99


def test_a_triangle_with_an_image(rng: np.random.Generator) -> None:
    """What its samples bring is what rays to it find."""
    builder = SceneBuilder()
    pixels = rng.random((8, 8, 3)).astype(np.float32) ** 4 * 20
    builder.description.images = [Image("panel", pixels, "linear")]
    shape = mesh("panel", [(-1, -1, 1), (1, -1, 1.2), (0, 1, 1)], [(0, 1, 2)])
    builder.add(shape, pictured("ShaderNodeEmission", "Generated"))
    scene = compiled(builder)
    at = receiver((0.1, 0.2, 0))
    s = assert_samples_follow_density(scene, at, rng)
    hits, radiance, _ = met(scene, at, s.wi[s.valid])
    ok = hits == 1
    assert np.median(abs(radiance[ok] / s.radiance[s.valid][ok, 0] - 1)) < 1e-4
    assert s.radiance[s.valid].std() > 0.1
