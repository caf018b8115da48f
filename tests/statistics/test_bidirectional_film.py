"""What splats do to a render's film: filters, borders, passes, threads, stops and stated errors."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest
from bidirectional_scenes import LIGHTS, MATERIALS, apart, build
from scenes import Array, SceneBuilder, diffuse, pictures, quad, render
from statistics_tools import assert_equal_means

import engine_core
from engine_core import probe

SEEDS = 8
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def started(
    builder: SceneBuilder, passes: tuple[str, ...] = ("Combined",), **settings: Any
) -> tuple[Any, tuple[int, int]]:
    scene = engine_core.compile(builder.description, threads=2)
    session = engine_core.Session(
        scene, {"integrator": "BDPT", "threads": 2, **settings}, list(passes)
    )
    session.start()
    return session, (scene.width, scene.height)


def read(session: Any, size: tuple[int, int], name: str = "Combined") -> Array:
    return np.asarray(session.read(name, 0, 0, *size), np.float64)


@pytest.mark.parametrize("integrator", ["BDPT", "LIGHT"])
def test_threads_change_no_more_than_the_order_of_sums(integrator: str) -> None:
    images = [
        render(apart("many", "pinhole"), integrator=integrator, samples=8, threads=threads)
        for threads in (1, 2, 5, 5)
    ]
    for image in images[1:]:
        # The sums are float64; what is read is float32.
        difference = abs(image["Combined"] - images[0]["Combined"])
        assert (difference <= np.finfo(np.float32).eps * abs(image["Combined"])).all()


@pytest.mark.parametrize("kind", ["BOX", "GAUSSIAN", "BLACKMAN_HARRIS"])
@pytest.mark.parametrize("width", [0.5, 1.0, 3.0])
def test_filter_densities(kind: str, width: float, rng: np.random.Generator) -> None:
    edges = np.linspace(-2.5 * width, 2.5 * width, 2001)
    middles = 0.5 * (edges[1:] + edges[:-1])
    density = np.array(probe.filter_densities(kind, width, middles.tolist()))
    mass = density * np.diff(edges)
    assert mass.sum() == pytest.approx(1.0, abs=2e-3)
    offsets = probe.filter_offsets(kind, width, rng.random((40_000, 2), np.float32))
    for axis in range(2):
        counts = np.histogram(offsets[:, axis], edges)[0].reshape(100, 20).sum(axis=1)
        expected = 40_000 * mass.reshape(100, 20).sum(axis=1)
        wide = expected > 50
        # Cells of the tabulated density straddle bins: their error beside that of counts.
        error = np.sqrt(expected[wide] + (0.02 * expected[wide]) ** 2)
        assert (abs(counts[wide] - expected[wide]) < 5 * error).all()


@pytest.mark.parametrize("integrator", ["BDPT", "LIGHT"])
@pytest.mark.parametrize(("kind", "width"), [("BOX", 1.0), ("BOX", 2.5), ("BLACKMAN_HARRIS", 1.5)])
def test_filters(kind: str, width: float, integrator: str) -> None:
    def scene() -> SceneBuilder:
        builder = apart("area", "pinhole")
        builder.description.film.filter = kind
        builder.description.film.filter_width = width
        return builder

    path = pictures(scene(), SEEDS, samples=128, max_bounces=3)
    other = pictures(scene(), SEEDS, samples=128, max_bounces=3, integrator=integrator)
    assert_equal_means(path, other, block=2)


@pytest.mark.parametrize("integrator", ["BDPT", "LIGHT"])
def test_a_border_is_part_of_the_full_frame(integrator: str) -> None:
    full = pictures(
        apart("area", "pinhole"), SEEDS, samples=128, max_bounces=3, integrator=integrator
    )
    part = pictures(apart("area", "crop"), SEEDS, samples=128, max_bounces=3, integrator=integrator)
    assert_equal_means(full[:, 2:8, 3:10], part, block=2)


LIGHT_PASSES = [
    f"{kind} {part}"
    for kind in ("Diffuse", "Glossy", "Transmission")
    for part in ("Direct", "Indirect")
]
COLOR_PASSES = [f"{kind} Color" for kind in ("Diffuse", "Glossy", "Transmission")]


def passes_of(material: str, integrator: str) -> dict[str, Array]:
    """What each pass adds to the picture, for each seed."""
    names = ["Combined", *LIGHT_PASSES, *COLOR_PASSES, "Emission", "Environment"]
    stacks: dict[str, list[Array]] = {}
    for seed in range(SEEDS):
        out = render(
            build(material, "many"), names, integrator=integrator, samples=64, max_bounces=4,
            seed=seed,
        )  # fmt: skip
        total = out["Emission"] + out["Environment"]
        for name in LIGHT_PASSES:
            light = out[name] * out[f"{name.split()[0]} Color"]
            stacks.setdefault(name, []).append(light)
            total = total + light
        # A splat on a surface of which no camera ray of the pixel met a colour is lost to its pass.
        met = np.all(
            [out[color].any(axis=-1) | ~out[color].any() for color in COLOR_PASSES], axis=0
        )
        whole = out["Combined"][..., :3]
        assert total[met] == pytest.approx(whole[met], rel=2e-4, abs=1e-6)
        assert total == pytest.approx(whole, rel=0.1, abs=1e-6)
        for name in ("Emission", "Environment"):
            stacks.setdefault(name, []).append(out[name])
    return {name: np.stack(images) for name, images in stacks.items()}


@pytest.mark.parametrize("material", ["principled", "rough_glass", "fresnel", "facing_clear"])
def test_light_passes(material: str) -> None:
    path, other = passes_of(material, "PATH"), passes_of(material, "BDPT")
    for name in path:
        assert_equal_means(path[name], other[name])


@pytest.mark.parametrize("integrator", ["BDPT", "LIGHT"])
def test_alpha(integrator: str) -> None:
    """A ball before nothing, on a transparent film, half of which lets through."""
    builder = SceneBuilder((12, 12))
    builder.add(quad((-1, -1, 0), (2, 0, 0), (0, 2, 0)), MATERIALS["half_clear"])
    builder.add(quad((-1.5, -1.5, -1), (1, 0, 0), (0, 1, 0)), diffuse(0.5))
    LIGHTS["area"](builder)
    builder.description.film.transparent = True
    alphas, colors = [], []
    for name in ("PATH", integrator):
        shots = [
            render(builder, integrator=name, samples=64, seed=seed, max_bounces=3)["Combined"]
            for seed in range(SEEDS)
        ]
        alphas.append(np.stack(shots)[..., 3:])
        colors.append(np.stack(shots)[..., :3])
    assert_equal_means(*alphas)
    assert_equal_means(*colors)


def endless() -> SceneBuilder:
    builder = build("principled", "many")
    film = builder.description.film
    film.width = film.height = 64
    film.crop = (0, 0, 64, 64)
    return builder


@pytest.mark.parametrize("stop", ["cancel", "time"])
def test_a_stopped_render_holds_whole_batches(stop: str) -> None:
    limit = {"time_limit": 0.7} if stop == "time" else {}
    session, size = started(endless(), ("Combined", "Debug Sample Count"), samples=1 << 20, **limit)
    if stop == "cancel":
        while session.poll().samples < 3:
            session.wait(0.01)
        session.cancel()
    assert session.wait(60.0)
    counts = read(session, size, "Debug Sample Count")
    total, possible = 0, {0}
    while total <= counts.max():
        total += probe.batch_samples(total, 16)
        possible.add(total)
    assert counts.min() == counts.max()
    assert counts.max() in possible
    assert np.isfinite(read(session, size)).all()


def pictures_of_one_sample(seeds: int) -> Array:
    return pictures(endless(), seeds, integrator="BDPT", samples=1, max_bounces=4)


def test_no_snapshot_is_darker_or_brighter_than_the_picture() -> None:
    """The mean of every snapshot lies within its own noise of the final one's."""
    session, size = started(endless(), ("Combined",), samples=96, max_bounces=4)
    means: list[tuple[float, float]] = []
    while not session.wait(0.02):
        samples = session.poll().samples
        means.append((samples, float(read(session, size)[..., :3].mean())))
    final = float(read(session, size)[..., :3].mean())
    # Of one sample, by independent renders; a snapshot may be of a batch more than was polled.
    single = pictures_of_one_sample(16).mean(axis=(1, 2, 3))
    deviation = float(np.std(single, ddof=1))
    seen = [(n, mean) for n, mean in means if n >= 1]
    assert seen
    for n, mean in seen:
        assert abs(mean - final) < 6 * deviation / np.sqrt(n), (n, mean, final)


def test_95_in_100_pixels_lie_within_their_stated_error() -> None:
    builder = endless()
    builder.description.film.width = builder.description.film.height = 24
    builder.description.film.crop = (0, 0, 24, 24)
    settings = {"max_bounces": 3}
    truth = render(builder, integrator="BDPT", samples=4096, seed=999, **settings)["Combined"]
    truth = truth[..., :3] @ LUMINANCE
    inside = []
    for seed in range(6):
        session, size = started(builder, ("Combined", "Error"), samples=64, seed=seed, **settings)
        assert session.wait(120.0)
        value = read(session, size)[..., :3] @ LUMINANCE
        half_width = read(session, size, "Error")[..., 0] * np.maximum(value, 0.01 * truth.mean())
        inside.append((abs(value - truth) <= half_width).mean())
    # Splats of rare paths have skewed errors: 64 samples tell a little less than they should.
    assert 0.90 < np.mean(inside) < 0.99, inside


def test_snapshots_may_be_read_while_splats_are_added() -> None:
    session, size = started(endless(), ("Combined", "Error"), samples=48)
    failures: list[BaseException] = []

    def look() -> None:
        try:
            while not session.poll(True).done:
                assert np.isfinite(read(session, size)).all()
                assert not np.isnan(read(session, size, "Error")).any()
        except BaseException as error:
            failures.append(error)

    readers = [threading.Thread(target=look) for _ in range(2)]
    for reader in readers:
        reader.start()
    for reader in readers:
        reader.join()
    assert not failures
    assert session.wait(60.0)
