"""Lights at the extremes of float32: finite samples, consistent densities, the same picture."""

from __future__ import annotations

import numpy as np
import pytest
from light_probes import (
    Emissions,
    Samples,
    compiled,
    met,
    receiver,
    sample,
    uniforms,
    unit,
)
from scenes import SceneBuilder, emission, mesh, placed

from engine_core import probe

KINDS = ["POINT", "SOFT", "SPOT", "AREA", "ELLIPSE", "SUN", "TRIANGLE"]


def scene_of(kind: str, power: float, size: float, at: np.ndarray) -> SceneBuilder:
    builder = SceneBuilder()
    flipped = np.diag([1.0, -1.0, -1.0])  # shines up: receivers are around
    if kind == "TRIANGLE":
        corners = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]]) * size + at
        builder.add(mesh("t", corners, [(0, 1, 2)]), emission(power))
    else:
        builder.light(
            {"SOFT": "POINT", "ELLIPSE": "AREA"}.get(kind, kind),
            transform=placed(flipped, at),
            emission=(power,) * 3,
            radius=size,
            soft_falloff=kind == "SOFT",
            size_x=size,
            size_y=2 * size,
            shape="ELLIPSE" if kind == "ELLIPSE" else "RECTANGLE",
            spread=np.pi,
            sun_angle=min(size, 3.0),
        )
    return builder


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("power", [1e-30, 1.0, 1e30])
@pytest.mark.parametrize("size", [1e-12, 1e-6, 1e-2, 1e3])
def test_everything_is_finite(
    kind: str, power: float, size: float, rng: np.random.Generator
) -> None:
    scene = compiled(scene_of(kind, power, size, np.zeros(3)))
    for distance in (1e-6, 1e-3, 1.0, 1e3, 1e7):
        for direction in ([0, 0, 1], [1, 1, 0], [1, 0, 1e-6], [0.3, 0.2, -1]):
            p = unit(direction) * distance
            at = receiver(p, -unit(direction))
            s = sample(scene, at, rng, 50)
            for column in (s.wi, s.radiance, s.pdf, s.pdf_selection, s.p, s.n):
                assert np.isfinite(column[s.valid]).all()
            assert (s.pdf[s.valid] > 0).all()
            assert (s.radiance[s.valid] >= 0).all()
            assert np.linalg.norm(s.wi[s.valid], axis=1) == pytest.approx(1, abs=1e-5)
            if kind != "SUN":
                assert np.isfinite(s.distance[s.valid]).all()
            _, radiance, pdf = met(scene, at, np.concatenate([s.wi[s.valid], -p[None]]))
            assert np.isfinite(radiance).all()
            assert np.isfinite(pdf).all()
    e = Emissions(probe.sample_emission(scene, uniforms(rng, 200, 5)))
    for column in (e.p, e.direction, e.n, e.radiance, e.pdf_position, e.pdf_direction):
        assert np.isfinite(column[e.valid]).all()


@pytest.mark.parametrize("kind", KINDS)
def test_receivers_on_the_light(kind: str, rng: np.random.Generator) -> None:
    """At its centre, on its surface and in its plane: no NaN, whatever is returned."""
    scene = compiled(scene_of(kind, 1.0, 1.0, np.zeros(3)))
    for p in ([0, 0, 0], [1, 0, 0], [0, 0, 1], [3, 0, 0], [0.2, 0.1, 0]):
        for transmits in (False, True):
            at = receiver(p, (0, 0, 1), transmits=transmits)
            s = sample(scene, at, rng, 200)
            assert np.isfinite(s.pdf[s.valid]).all()
            assert np.isfinite(s.radiance[s.valid]).all()
            d = unit(rng.normal(size=(200, 3)))
            _, radiance, pdf = met(scene, at, d)
            assert np.isfinite(radiance).all()
            assert np.isfinite(pdf).all()


@pytest.mark.parametrize("kind", [k for k in KINDS if k != "SUN"])
@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
def test_scale_changes_no_picture(kind: str, scale: float) -> None:
    """A scene s times as large whose lamps have s^2 the power has the same radiances."""
    power = 1.0 if kind == "TRIANGLE" else scale**2
    small = compiled(scene_of(kind, 1.0, 0.5, np.zeros(3)))
    large = compiled(scene_of(kind, power, 0.5 * scale, np.zeros(3)))
    p = np.array([0.3, 0.4, 1.0])
    u = uniforms(np.random.default_rng(5), 500, 3)
    a = Samples(probe.sample_lights(small, receiver(p, -p), u))
    b = Samples(probe.sample_lights(large, receiver(p * scale, -p), u))
    both = a.valid & b.valid
    assert both.mean() > 0.3
    assert (a.valid == b.valid).mean() > 0.999
    ratio = (b.radiance[both, 0] / b.pdf[both]) / (a.radiance[both, 0] / a.pdf[both])
    assert np.median(ratio) == pytest.approx(1, rel=1e-5)
    assert ratio == pytest.approx(1, rel=5e-3)
    assert (a.wi[both] * b.wi[both]).sum(axis=1) == pytest.approx(1, abs=1e-5)


def test_powers_sixty_orders_apart(rng: np.random.Generator) -> None:
    """Both lights of such a pair keep a chance, and no sum overflows."""
    builder = scene_of("POINT", 1e30, 0.1, np.array([0, 0, 2.0]))
    for x in (1.0, 2.0):
        builder.light("POINT", emission=(1e-30,) * 3, transform=placed(1, (x, 0, 2)))
    scene = compiled(builder)
    p = probe.selection_pdf(
        scene, np.repeat(receiver((0, 0, 0)), 3, axis=0), np.arange(3, dtype=np.uint32)
    )[:, 0]
    assert (p > 0).all()
    assert p.sum() == pytest.approx(1, rel=1e-5)


def test_lamps_without_extent_or_power_are_dark(rng: np.random.Generator) -> None:
    for fields in (
        {"kind": "AREA", "size_x": 0.0},
        {"kind": "AREA", "transform": placed(0.0)},
        {"kind": "SUN", "transform": placed(0.0)},
        {"kind": "POINT", "emission": (0.0, 0.0, 0.0)},
    ):
        builder = SceneBuilder()
        builder.light(**fields)
        scene = compiled(builder)
        assert not sample(scene, receiver((0, 0, -1)), rng, 50).valid.any()
        assert not Emissions(probe.sample_emission(scene, uniforms(rng, 50, 5))).valid.any()


@pytest.mark.parametrize("place", [np.nan, np.inf, 3e38])
@pytest.mark.parametrize("lamps", [1, 3, 100])
def test_a_place_that_is_no_number_ends_the_choice(
    place: float, lamps: int, rng: np.random.Generator
) -> None:
    builder = SceneBuilder()
    for at in rng.uniform(-1, 1, (lamps, 3)):
        builder.light("POINT", transform=placed(1, at), radius=0.01)
    builder.light("SUN")
    scene = compiled(builder)
    for column in range(9):  # of the place and both normals
        at = receiver((0.1, 0.2, 0.3))
        at[0, column] = place
        s = sample(scene, at, rng, 200)
        assert (s.light[s.valid] <= lamps).all()
