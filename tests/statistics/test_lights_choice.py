"""The choice among many lights: frequencies, completeness, and agreement with plain sums."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from light_probes import Samples, compiled, receiver, sample, uniforms, unit
from scenes import SceneBuilder, background, emission, mesh, placed
from statistics_tools import assert_chi_squared, assert_mean_is

from engine_core import probe


def rotation(rng: np.random.Generator) -> np.ndarray:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.diag(r))


def add_lamps(builder: SceneBuilder, rng: np.random.Generator, count: int) -> None:
    for i in range(count):
        kind = ["POINT", "SPOT", "AREA"][i % 3]
        place = placed(rotation(rng), rng.uniform(-5, 5, 3))
        builder.light(
            kind,
            transform=place,
            emission=tuple(rng.lognormal(0, 1.5, 3)),
            radius=float(rng.choice([0.0, 0.2])),
            soft_falloff=bool(i % 2),
            spot_angle=float(rng.uniform(0.3, 2.5)),
            spread=float(rng.choice([np.pi, 1.5])),
            shape="ELLIPSE" if i % 2 else "RECTANGLE",
            size_x=float(rng.uniform(0.05, 1.0)),
            size_y=float(rng.uniform(0.05, 1.0)),
        )


def add_triangles(builder: SceneBuilder, rng: np.random.Generator, count: int) -> None:
    corners = rng.uniform(-5, 5, (count, 1, 3)) + rng.normal(0, 0.3, (count, 3, 3))
    faces = np.arange(3 * count).reshape(count, 3).tolist()
    builder.add(mesh("lights", corners.reshape(-1, 3), faces), emission(2.0))


@pytest.fixture
def many(rng: np.random.Generator) -> Any:
    """90 lamps, 60 triangles, two suns and a world."""
    builder = SceneBuilder()
    add_lamps(builder, rng, 90)
    add_triangles(builder, rng, 60)
    for angle in (0.0, 0.3):
        builder.light("SUN", transform=placed(rotation(rng)), sun_angle=angle)
    builder.description.world = background(0.05)
    return compiled(builder)


def receivers(rng: np.random.Generator, count: int) -> np.ndarray:
    rows = np.zeros((count, 10), np.float32)
    rows[:, :3] = rng.uniform(-6, 6, (count, 3))
    rows[:, 3:6] = unit(rng.normal(size=(count, 3)))
    # Shading normals within some 20 degrees, as bent ones are.
    rows[:, 6:9] = unit(rows[:, 3:6] + rng.normal(0, 0.2, (count, 3)))
    rows[:, 9] = rng.random(count) < 0.3
    return rows


def complemented(at: np.ndarray) -> np.ndarray:
    """The same receivers, where other directions find the world as well."""
    return np.concatenate([at, np.ones((len(at), 1), np.float32)], axis=1)


def narrow(at: np.ndarray) -> np.ndarray:
    """The same, which scatter to few directions."""
    return np.concatenate([at, np.ones((len(at), 2), np.float32)], axis=1)


RECEIVERS = {"alone": lambda at: at, "complemented": complemented, "narrow": narrow}


def all_selections(scene: Any, at: np.ndarray) -> np.ndarray:
    """Probability of every light for every receiver: (receivers, lights)."""
    count = probe.light_summary(scene)["count"]
    rows = np.repeat(at, count, axis=0)
    lights = np.tile(np.arange(count, dtype=np.uint32), len(at))
    p = np.asarray(probe.selection_pdf(scene, rows, lights), np.float64)
    return p.reshape(len(at), count)


def test_probabilities_sum_to_one(many: Any, rng: np.random.Generator) -> None:
    total = all_selections(many, receivers(rng, 300)).sum(axis=1)
    assert (total < 1 + 1e-4).all()
    # Less where a branch promised what none of its lights keeps: such choices are of no light.
    assert np.median(total) > 0.95
    assert total.mean() > 0.9
    transmitting = receivers(rng, 300)
    transmitting[:, 9] = 1
    assert all_selections(many, transmitting).sum(axis=1).mean() > 0.95


def test_no_light_that_contributes_is_left_out(many: Any, rng: np.random.Generator) -> None:
    at = receivers(rng, 200)
    p = all_selections(many, at)
    count = p.shape[1]
    lights = np.tile(np.arange(count, dtype=np.uint32), len(at))
    for _ in range(4):
        u = uniforms(rng, len(lights), 2)
        s = Samples(probe.sample_given_lights(many, np.repeat(at, count, axis=0), lights, u))
        cos_ng = (s.wi * np.repeat(at[:, 3:6], count, axis=0)).sum(axis=1)
        transmits = np.repeat(at[:, 9] > 0, count)
        lit = s.valid & ((cos_ng > 1e-4) | transmits)
        assert lit.sum() > 1000
        assert (p.reshape(-1)[lit] > 0).all()


@pytest.mark.parametrize("offset", [0.0, 1e4])
def test_narrow_beams_are_not_left_out(offset: float, rng: np.random.Generator) -> None:
    """The tree's cones and spheres are rounded: outward, so that what they hold is chosen."""
    builder = SceneBuilder()
    lamps = 200
    turns = [rotation(rng) for _ in range(lamps)]
    places = rng.uniform(-5, 5, (lamps, 3)) + offset
    angles = 10 ** rng.uniform(-2, 0, lamps)
    for i in range(lamps):
        builder.light(
            ["SPOT", "AREA"][i % 2],
            transform=placed(turns[i], places[i]),
            emission=tuple(rng.lognormal(0, 1.5, 3)),
            spot_angle=float(angles[i]),
            spread=float(angles[i]),
            size_x=0.1,
            size_y=0.1,
        )
    # As far away on the other side: the origin of render space is between them.
    builder.light("POINT", transform=placed(1, (-offset, 0, 0)))
    scene = compiled(builder)
    each = 50
    rows = np.zeros((lamps, each, 10), np.float32)
    for i in range(lamps):
        along = np.array([[0, 0, -1.0]]) + rng.normal(0, angles[i] / 4, (each, 3)) * [1, 1, 0]
        toward = unit(along) @ turns[i].T
        rows[i, :, :3] = places[i] + toward * rng.uniform(0.5, 5, (each, 1))
        rows[i, :, 3:6] = rows[i, :, 6:9] = -toward
    flat = rows.reshape(-1, 10)
    lights = np.repeat(np.arange(lamps, dtype=np.uint32), each)
    s = Samples(probe.sample_given_lights(scene, flat, lights, uniforms(rng, len(flat), 2)))
    assert s.valid.mean() > 0.5
    p = np.asarray(probe.selection_pdf(scene, flat, lights))[:, 0]
    assert (p[s.valid] > 0).all()


@pytest.mark.parametrize("kind", RECEIVERS)
def test_lights_are_chosen_as_often_as_they_should(
    many: Any, kind: str, rng: np.random.Generator
) -> None:
    n = 20_000
    for at in RECEIVERS[kind](receivers(rng, 5)):
        s = sample(many, at[None], rng, n)
        p = all_selections(many, at[None])[0]
        assert s.pdf_selection[s.valid] == pytest.approx(p[s.light[s.valid]], rel=1e-4)
        # Of every light, some samples have no value: its choices are counted by their share.
        u = uniforms(rng, len(p) * 200, 2)
        lights = np.repeat(np.arange(len(p), dtype=np.uint32), 200)
        rows = np.repeat(at[None], len(lights), axis=0)
        given = Samples(probe.sample_given_lights(many, rows, lights, u))
        always = given.valid.reshape(len(p), 200).mean(axis=1) == 1.0
        observed = np.bincount(s.light[s.valid], minlength=len(p))[always]
        expected = n * p[always]
        assert always.sum() > 20
        assert_chi_squared(
            np.append(observed, n - observed.sum()), np.append(expected, n - expected.sum())
        )


def cosine_weighted(at: np.ndarray) -> Callable[[Samples], np.ndarray]:
    """What samples bring to a grey matte receiver, which may also be a thin sheet."""
    ng, ns = at[3:6].astype(np.float64), at[6:9].astype(np.float64)

    def value(s: Samples) -> np.ndarray:
        cosine = s.wi @ ns
        in_front = np.where(s.wi @ ng > 0, np.maximum(cosine, 0), 0)
        cosine = abs(cosine) if at[9] > 0 else in_front
        return np.where(s.valid, s.radiance.mean(1) * cosine / np.maximum(s.pdf, 1e-30), 0)

    return value


def test_the_choice_changes_no_irradiance(many: Any, rng: np.random.Generator) -> None:
    """One light by the tree, against the sum over all lights."""
    n = 30_000
    for at in receivers(rng, 4):
        value = cosine_weighted(at)
        chosen = value(sample(many, at[None], rng, n))
        count = probe.light_summary(many)["count"]
        each = 400
        lights = np.repeat(np.arange(count, dtype=np.uint32), each)
        rows = np.repeat(at[None], len(lights), axis=0)
        given = Samples(
            probe.sample_given_lights(many, rows, lights, uniforms(rng, len(lights), 2))
        )
        per_light = value(given).reshape(count, each)
        truth = per_light.mean(axis=1).sum()
        truth_error = np.sqrt((per_light.var(axis=1) / each).sum())
        error = np.hypot(chosen.std() / np.sqrt(n), truth_error)
        assert abs(chosen.mean() - truth) < 4.5 * error
        # And it is worth its while: far better than a blind choice.
        blind = np.sqrt(count * (per_light**2).mean(axis=1).sum() - truth**2)
        assert chosen.std() < 0.5 * blind


def test_one_light_is_always_chosen() -> None:
    builder = SceneBuilder()
    builder.light("POINT", transform=placed(1, (0, 0, -3)))
    scene = compiled(builder)
    assert all_selections(scene, receiver((0, 0, 0)))[0, 0] == 1


def test_lights_behind_an_opaque_receiver_are_not_chosen(rng: np.random.Generator) -> None:
    builder = SceneBuilder()
    for z in (-3, -2, 2, 3):
        builder.light("POINT", transform=placed(1, (0.1 * z, 0, z)))
    scene = compiled(builder)
    opaque = all_selections(scene, receiver((0, 0, 0)))[0]
    assert (opaque[:2] == 0).all()
    assert (opaque[2:] > 0).all()
    assert (all_selections(scene, receiver((0, 0, 0), transmits=True))[0] > 0).all()


def test_a_lamp_indoors_does_not_starve_beside_the_sun() -> None:
    builder = SceneBuilder()
    builder.light("SUN", emission=(1000.0,) * 3, transform=placed())
    builder.light("POINT", emission=(1.0,) * 3, transform=placed(1, (0, 0, 2)))
    p = all_selections(compiled(builder), receiver((0, 0, 0)))[0]
    assert p.sum() == pytest.approx(1)
    assert p[1] > 0.05


@pytest.mark.parametrize(("sky", "probability"), [(0.2, 0.01), (2e4, 0.99)])
def test_a_plain_sky_is_left_to_other_directions(sky: float, probability: float) -> None:
    """But where it outshines all lamps, samples that go to it cost those nothing."""
    builder = SceneBuilder()
    builder.light("SUN", emission=(10.0,) * 3, transform=placed())
    builder.description.world = background(sky)
    at = receiver((0, 0, 0))
    scene = compiled(builder)
    alone, shared = (all_selections(scene, rows)[0] for rows in (at, complemented(at)))
    assert alone.sum() == pytest.approx(1)
    assert shared.sum() == pytest.approx(1)
    assert alone[1] > 0.1
    assert (shared[1] < probability) == (sky < 1.0)


@pytest.mark.parametrize("lamp", [False, True])
def test_a_plain_sky_is_left_to_narrow_receivers_altogether(
    lamp: bool, rng: np.random.Generator
) -> None:
    builder = SceneBuilder()
    if lamp:
        builder.light("SUN", emission=(10.0,) * 3, transform=placed())
    builder.description.world = background(2e4)
    at = receiver((0, 0, 0))
    scene = compiled(builder)
    sky = all_selections(scene, narrow(at))[0][-1]
    assert sky == 0
    assert all_selections(scene, complemented(at))[0][-1] > 0.9
    chosen = sample(scene, narrow(at), rng, 1000)
    assert chosen.valid.all() == chosen.valid.any() == lamp
    if lamp:
        assert (chosen.light == 0).all()
        assert chosen.pdf_selection == pytest.approx(1)
    # Turned away from the lamp nothing else is left, and nothing has a chance.
    away = receiver((0, 0, 0), ng=(0, 0, -1))
    assert (all_selections(scene, narrow(away)) == 0).all()


def test_triangles_are_told_from_dark_ones(rng: np.random.Generator) -> None:
    """Meshes that mix emissive and dark faces, instanced: each hit finds its own light."""
    builder = SceneBuilder()
    d = builder.description
    corners = rng.uniform(-1, 1, (200 * 3, 3))
    shape = mesh("mixed", corners, np.arange(600).reshape(200, 3).tolist())
    dark = builder.material(emission(0.0))
    bright = builder.material(emission(1.0))
    shape.face_materials = (rng.random(200) < 0.4).astype(np.int32)
    index = builder.mesh(shape)
    for x in (-3, 0, 3):
        builder.instance(index, dark, placed(1.0, (x, 0, 0)))
        d.material_sets[-1] = [dark, bright]
    scene = compiled(builder)
    summary = probe.light_summary(scene)
    assert summary["triangles"] == 3 * shape.face_materials.sum()
    # Samples land on the triangles that the index tells them to be.
    s = sample(scene, receiver((0, 0, -9)), rng, 3000)
    n = s.n[s.valid].astype(np.float32)
    rows = np.concatenate([s.wi[s.valid], s.distance[s.valid][:, None], n], axis=1)
    again = probe.light_pdf(scene, receiver((0, 0, -9)), s.light[s.valid], rows.astype(np.float32))
    assert again[:, 0] == pytest.approx(s.pdf[s.valid], rel=2e-3)


def test_mean_of_selection_weights_is_the_number_of_lights(
    many: Any, rng: np.random.Generator
) -> None:
    """E[1 / p] over choices is the number of lights that can be chosen."""
    at = receivers(rng, 1)
    p = all_selections(many, at)[0]
    n = 200_000
    chances = p / p.sum()
    picked = rng.choice(len(p), n, p=chances)
    assert_mean_is((1 / chances[picked])[:, None], (p > 0).sum())
