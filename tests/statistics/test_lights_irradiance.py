"""What lights send to a point, against closed forms, and as light tracing sees it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from light_probes import Emissions, Samples, compiled, receiver, sample, uniforms, unit
from scenes import SceneBuilder, background, emission, look_at, mesh, placed
from statistics_tools import assert_chi_squared, assert_mean_is

from engine_core import probe

Vector = tuple[float, float, float]
WATTS = 5.0
UP = np.array([0.0, 0.0, 1.0])


def lamp(kind: str, **fields: object) -> SceneBuilder:
    builder = SceneBuilder()
    builder.light(kind, **{"emission": (WATTS,) * 3, **fields})
    return builder


def above(height: float, linear: object = 1.0) -> object:
    return placed(linear, (0, 0, height))


def triangle_irradiance(corners: np.ndarray, normal: np.ndarray) -> float:
    """Lambert's formula for a polygon of radiance 1 above the horizon, at the origin."""
    a = unit(corners)
    b = np.roll(a, -1, axis=0)
    cross = np.cross(a, b)
    angle = np.arctan2(np.linalg.norm(cross, axis=1), (a * b).sum(axis=1))
    return 0.5 * abs((angle[:, None] * unit(cross) @ normal).sum())


def rectangle_irradiance() -> float:
    corners = np.array([[-1, -0.5, 2], [1, -0.5, 2], [1, 0.5, 2], [-1, 0.5, 2]], float)
    return WATTS / (np.pi * 2.0) * triangle_irradiance(corners, UP)


# Scene and irradiance at the origin, normal up.
CLOSED_FORMS: dict[str, tuple[Callable[[], SceneBuilder], float]] = {
    # Cycles' watts of a point are 4 pi times its intensity.
    "point": (lambda: lamp("POINT", transform=above(2)), WATTS / (4 * np.pi) / 4),
    "point, not normalised": (
        lambda: lamp("POINT", transform=above(2), normalize=False),
        WATTS / np.pi / 4,
    ),
    "sphere": (
        lambda: lamp("POINT", transform=above(2), radius=0.5, soft_falloff=False),
        WATTS / (4 * np.pi**2 * 0.25) * np.pi * (0.5 / 2) ** 2,
    ),
    "facing disk": (
        lambda: lamp("POINT", transform=above(2), radius=0.5, soft_falloff=True),
        WATTS / (4 * np.pi**2 * 0.25) * np.pi * 0.25 / (4 + 0.25),
    ),
    # On its axis a spot is as bright as a point.
    "spot": (lambda: lamp("SPOT", transform=above(2)), WATTS / (4 * np.pi) / 4),
    "sun": (
        lambda: lamp("SUN", transform=look_at((0, 3, 4), (0, 0, 0)), sun_angle=np.radians(20)),
        WATTS * 0.8,
    ),
    "sun, a direction": (
        lambda: lamp("SUN", transform=look_at((0, 3, 4), (0, 0, 0)), sun_angle=0.0),
        WATTS * 0.8,
    ),
    "rectangle": (
        lambda: lamp("AREA", transform=above(2), size_x=2.0, size_y=1.0),
        rectangle_irradiance(),
    ),
    "disk": (
        lambda: lamp("AREA", transform=above(2), shape="ELLIPSE", size_x=2.0, size_y=2.0),
        WATTS / (np.pi * np.pi) * np.pi / (1 + 4),
    ),
    "disk, scaled, not normalised": (
        lambda: lamp("AREA", transform=above(2, 2.0), shape="ELLIPSE", normalize=False),
        WATTS / np.pi * np.pi / (1 + 4),
    ),
    "parallel area": (lambda: lamp("AREA", transform=above(2), spread=0.0, size_x=2.0), WATTS / 2),
    "triangle": (
        lambda: emissive_triangle(),
        3.0 * triangle_irradiance(np.array([[-1, -1, 1], [1.5, -1, 2], [0, 1, 1.5]]), UP),
    ),
}


def emissive_triangle() -> SceneBuilder:
    builder = SceneBuilder()
    builder.add(mesh("t", [(-1, -1, 1), (1.5, -1, 2), (0, 1, 1.5)], [(0, 1, 2)]), emission(3.0))
    return builder


def irradiance_samples(s: Samples, normal: np.ndarray = UP) -> np.ndarray:
    value = np.zeros(len(s.pdf))
    ok = s.valid
    value[ok] = s.radiance[ok, 0] * np.maximum(s.wi[ok] @ normal, 0) / s.pdf[ok]
    return value


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_irradiance_is_the_closed_form(name: str, rng: np.random.Generator) -> None:
    make, truth = CLOSED_FORMS[name]
    s = sample(compiled(make()), receiver((0, 0, 0)), rng, 40_000)
    assert_mean_is(irradiance_samples(s)[:, None], truth, 2e-5)


@pytest.mark.parametrize("transmits", [False, True])
def test_irradiance_of_a_uniform_world(transmits: bool, rng: np.random.Generator) -> None:
    builder = SceneBuilder()
    builder.description.world = background(2.0)
    s = sample(compiled(builder), receiver((0, 0, 0), transmits=transmits), rng, 40_000)
    assert_mean_is(irradiance_samples(s)[:, None], 2 * np.pi, 1e-5)


def test_a_spot_falls_off_as_a_smooth_step_of_the_cosine() -> None:
    half, blend = np.radians(30), 0.4
    scene = compiled(lamp("SPOT", transform=above(2), spot_angle=2 * half, spot_blend=blend))
    angles = np.radians([0, 10, 20, 25, 28, 29.9, 30.1, 50])
    rows = np.concatenate([receiver((2 * np.tan(a), 0, 0)) for a in angles])
    u = np.zeros((len(angles), 3), np.float32)
    s = Samples(probe.sample_lights(scene, rows, u))
    x = np.clip((np.cos(angles) - np.cos(half)) / ((1 - np.cos(half)) * blend), 0, 1)
    expected = WATTS / (4 * np.pi) * (np.cos(angles) / 2) ** 2 * x * x * (3 - 2 * x)
    assert s.radiance[:, 0] == pytest.approx(expected, rel=2e-4, abs=1e-9)


# Lamps whose light is followed from the lamp to a disk of radius 1.5 about the origin.
TRACED: dict[str, Callable[[], SceneBuilder]] = {
    "point": lambda: lamp("POINT", transform=above(2)),
    "sphere": lambda: lamp("POINT", transform=above(1), radius=0.6, soft_falloff=False),
    "facing disk": lambda: lamp("POINT", transform=above(1), radius=0.8, soft_falloff=True),
    "spot": lambda: lamp("SPOT", transform=above(2), spot_angle=np.radians(50)),
    "spot sphere": lambda: lamp(
        "SPOT",
        transform=above(2, np.diag([2.0, 1.0, 1.0])),
        radius=0.4,
        soft_falloff=False,
        spot_angle=np.radians(40),
    ),
    "spot disk": lambda: lamp(
        "SPOT", transform=above(1.5), radius=0.5, spot_angle=np.radians(60), spot_blend=1.0
    ),
    "rectangle": lambda: lamp("AREA", transform=above(1), size_x=2.0, size_y=0.5),
    "ellipse, spread": lambda: lamp(
        "AREA", transform=above(1), shape="ELLIPSE", size_x=2.0, spread=np.radians(70)
    ),
    "rectangle, sheared": lambda: lamp(
        "AREA", transform=above(1, np.array([[1, 0.5, 0], [0, 1, 0], [0, 0, 1.0]]))
    ),
    "triangle": lambda: emissive_triangle(),
}


@pytest.mark.parametrize("name", TRACED)
def test_light_tracing_agrees_with_light_sampling(name: str, rng: np.random.Generator) -> None:
    scene = compiled(TRACED[name]())
    n, disk = 100_000, 1.5
    # Watts on the disk: by sampling the lamp from random points of it...
    r, phi = disk * np.sqrt(rng.random(n)), 2 * np.pi * rng.random(n)
    rows = np.repeat(receiver((0, 0, 0)), n, axis=0)
    rows[:, 0], rows[:, 1] = r * np.cos(phi), r * np.sin(phi)
    s = Samples(probe.sample_lights(scene, rows, uniforms(rng, n, 3)))
    received = irradiance_samples(s) * np.pi * disk**2
    # ...and by following its light.
    e = Emissions(probe.sample_emission(scene, uniforms(rng, n, 5)))
    down = e.valid & (e.direction[:, 2] < 0)
    t = np.where(down, -e.p[:, 2] / np.where(down, e.direction[:, 2], -1), 0)
    q = e.p + e.direction * t[:, None]
    on = down & (np.hypot(q[:, 0], q[:, 1]) < disk) & (t > e.lit_from)
    arrived = np.where(on, e.flux() * n, 0.0)
    difference = received.mean() - arrived.mean()
    error = np.sqrt((received.var() + arrived.var()) / n)
    assert abs(difference) < 4.5 * error, f"{received.mean():.5g} and {arrived.mean():.5g}"
    assert error < 0.02 * received.mean()


def test_infinite_lights_fill_the_bounding_sphere(rng: np.random.Generator) -> None:
    builder = lamp("SUN", transform=look_at((0, 3, 4), (0, 0, 0)), sun_angle=np.radians(8))
    corners = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, 1)]
    builder.add(mesh("m", corners, [(0, 1, 2), (0, 2, 3)]))
    builder.description.world = background(0.5)
    scene = compiled(builder)
    radius2 = 3.0
    e = Emissions(probe.sample_emission(scene, uniforms(rng, 50_000, 5)))
    # Sun: E times the disk; the world: pi times as much radiance into each of 4 pi steradians.
    sun, world = WATTS * np.pi * radius2, 4 * np.pi * 0.5 * np.pi * radius2
    assert probe.light_summary(scene)["total_power"] == pytest.approx(sun + world, rel=1e-3)
    for number, power in [(0, sun), (1, world)]:
        mine = np.where(e.light == number, e.flux(), 0) * len(e.light)
        assert_mean_is(mine[:, None], power, 1e-3)
    # They start on the near side of the sphere's tangent planes.
    assert (np.linalg.norm(e.p, axis=1)[e.valid] < np.sqrt(2 * radius2) * 1.001).all()
    assert ((e.p * e.direction).sum(axis=1)[e.valid] < 0).all()


@pytest.mark.parametrize("name", TRACED)
def test_emission_densities_are_those_of_the_record(name: str, rng: np.random.Generator) -> None:
    scene = compiled(TRACED[name]())
    e = Emissions(probe.sample_emission(scene, uniforms(rng, 2000, 5)))
    ok = e.valid
    rows = np.concatenate([e.n, e.direction], axis=1)[ok].astype(np.float32)
    pdf = np.asarray(probe.emission_pdf(scene, e.light[ok], rows), np.float64)
    assert pdf[:, 0] == pytest.approx(e.pdf_position[ok], rel=1e-4)
    assert pdf[:, 1] == pytest.approx(e.pdf_direction[ok], rel=2e-3, abs=1e-6)
    assert pdf[:, 2] == pytest.approx(e.pdf_selection[ok], rel=1e-4)


def test_emission_is_chosen_by_power(rng: np.random.Generator) -> None:
    builder = lamp("POINT", transform=above(1))
    builder.light("AREA", emission=(20.0,) * 3, transform=above(2))
    builder.light("SPOT", emission=(7.0,) * 3, transform=above(3), radius=0.1)
    builder.add(mesh("t", [(-1, -1, 0), (1, -1, 0), (0, 1, 0)], [(0, 1, 2)]), emission(0.5))
    scene = compiled(builder)
    n = 40_000
    e = Emissions(probe.sample_emission(scene, uniforms(rng, n, 5)))
    count = probe.light_summary(scene)["count"]
    lights = np.arange(count, dtype=np.uint32)
    chance = np.asarray(probe.emission_pdf(scene, lights, np.ones((count, 6), np.float32)))[:, 2]
    assert chance.sum() == pytest.approx(1, rel=1e-5)
    counts = np.bincount(e.light[e.valid], minlength=count) + np.bincount(
        e.light[~e.valid], minlength=count
    )
    assert_chi_squared(counts.astype(float), n * chance.astype(float))
    # Triangle 2 m^2 both sides; point and area have their watts.
    assert chance[1] / chance[0] == pytest.approx(WATTS / (2 * 2 * np.pi * 0.5), rel=1e-4)
    assert chance[2] / chance[1] == pytest.approx(20 / WATTS, rel=1e-4)


@pytest.mark.parametrize("name", ["rectangle", "ellipse, spread", "triangle", "sphere"])
def test_emission_fills_positions_and_directions_by_density(
    name: str, rng: np.random.Generator
) -> None:
    """With z the cosine to the normal: cells of (position along x, z) against both densities."""
    scene = compiled(TRACED[name]())
    n = 100_000
    e = Emissions(probe.sample_emission(scene, uniforms(rng, n, 5)))
    assert e.valid.mean() > 0.98
    # Weighting by 1 / pdf makes the area and the projected solid angle uniform.
    weight = e.cosine / np.where(e.valid, e.pdf_position * e.pdf_direction, 1)
    area = {"rectangle": 1.0, "ellipse, spread": np.pi / 2, "sphere": 4 * np.pi * 0.36}.get(
        name, 2 * 0.5 * np.linalg.norm(np.cross([2.5, 0, 1], [1, 2, 0.5]))
    )
    sine2 = np.sin(np.radians(35)) ** 2 if name == "ellipse, spread" else 1.0
    assert_mean_is(np.where(e.valid, weight, 0)[:, None], area * np.pi * sine2, 1e-4)
    # sin^2 of the angle to the normal is uniform for light by the cosine.
    observed = np.histogram((1 - e.cosine[e.valid] ** 2) / sine2, bins=20, range=(0, 1))[0]
    assert_chi_squared(observed.astype(float), np.full(20, e.valid.sum() / 20.0))
