"""The statement of accuracy: its formulas against others', and whether it keeps its promise."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scenes import Array, SceneBuilder, background, diffuse, emission, placed, quad, sphere
from scipy import stats

import engine_core
from engine_core import probe

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def test_interval_factors_are_student_s_quantiles() -> None:
    counts = np.unique(np.geomspace(2, 1e6, 400).astype(int))
    factors = np.array([probe.interval_factor(int(count)) for count in counts])
    truth = stats.t.ppf(0.975, counts - 1)
    # The table has four decimals, and the expansion that follows it is better.
    assert np.all(abs(factors - truth) < 6e-5)
    assert np.all(np.diff(factors) < 0)
    assert math.isinf(probe.interval_factor(0))
    assert math.isinf(probe.interval_factor(1))


@pytest.mark.parametrize("scale", [1e-150, 1e-6, 1.0, 1e12, 1e150])
def test_standard_error_of_equal_batches_is_numpy_s(rng: np.random.Generator, scale: float) -> None:
    for batches in (2, 3, 10, 500):
        means = scale * (2.0 + rng.normal(size=batches))
        error = probe.standard_error(
            5.0 * batches, float(5 * means.sum()), float(5 * (means**2).sum()), batches
        )
        assert error == pytest.approx(means.std(ddof=1) / math.sqrt(batches), rel=1e-9)


def test_standard_error_of_unequal_batches_weighs_them_by_size(rng: np.random.Generator) -> None:
    sizes = np.array([1, 1, 1, 1, 2, 2, 4, 4, 8, 16], np.float64)
    means = rng.normal(size=len(sizes)) / np.sqrt(sizes)
    n = sizes.sum()
    mean = (sizes * means).sum() / n
    spread = (sizes * (means - mean) ** 2).sum() / (len(sizes) - 1)
    error = probe.standard_error(n, (sizes * means).sum(), (sizes * means**2).sum(), len(sizes))
    assert error == pytest.approx(math.sqrt(spread / n), rel=1e-12)


def test_standard_error_of_unequal_independent_batches_is_unbiased() -> None:
    """The mean of its square over many renders is the variance of the mean."""
    rng = np.random.default_rng(3)
    sizes = np.array([1] * 8 + [2] * 4 + [4] * 4 + [8] * 4, np.float64)
    runs = 4000
    means = rng.exponential(size=(runs, len(sizes), 8))  # a batch of k: mean of the first k
    means = np.stack([means[:, b, : int(k)].mean(axis=1) for b, k in enumerate(sizes)], axis=1)
    n = sizes.sum()
    squares = np.array(
        [
            probe.standard_error(n, (sizes * m).sum(), (sizes * m**2).sum(), len(sizes)) ** 2
            for m in means
        ]
    )
    truth = 1.0 / n  # an exponential variable of mean 1 has variance 1
    assert abs(squares.mean() - truth) < 4.5 * squares.std() / math.sqrt(runs)


def test_standard_error_at_its_ends() -> None:
    assert math.isinf(probe.standard_error(1.0, 2.0, 4.0, 1))
    assert math.isinf(probe.standard_error(0.0, 0.0, 0.0, 0))
    assert probe.standard_error(8.0, 0.0, 0.0, 8) == 0.0
    # Batches that agree: rounding must not make a negative variance.
    for value in (0.1, 1 / 3, 1e-20, 1e20):
        error = probe.standard_error(7.0, sum([value] * 7), sum([value**2] * 7), 7)
        assert 0.0 <= error < 1e-7 * value


def test_relative_errors_are_relative_to_the_pixel_or_to_a_hundredth_of_the_mean() -> None:
    assert probe.relative_error(2.0, 0.5, 10.0) == 0.25
    assert probe.relative_error(-2.0, 0.5, 10.0) == 0.25
    assert probe.relative_error(0.05, 0.5, 10.0) == 5.0
    assert probe.relative_error(0.0, 0.0, 0.0) == 0.0
    assert math.isinf(probe.relative_error(0.0, 1.0, 0.0))
    assert math.isinf(probe.relative_error(1.0, math.inf, 1.0))


def test_a_picture_s_error_is_not_exceeded_by_95_in_100_pixels(rng: np.random.Generator) -> None:
    assert math.isinf(probe.picture_error([]))
    for count in (1, 2, 19, 20, 21, 99, 100, 101, 1000):
        errors = rng.permutation(np.arange(1, count + 1)).astype(float)
        found = probe.picture_error(errors.tolist())
        assert (errors <= found).mean() >= 0.95
        assert (errors < found).mean() < 0.95
    assert math.isinf(probe.picture_error([0.1] * 18 + [math.inf] * 2))


def smooth_scene() -> SceneBuilder:
    """Soft light on matte surfaces: no rare events that a short render could miss."""
    builder = SceneBuilder((40, 40))
    builder.camera((0, -5, 3), (0, 0, 0.3))
    builder.add(quad((-4, -4, 0), (8, 0, 0), (0, 8, 0)), diffuse(0.5))
    builder.add(sphere(0.8, (0, 0, 0.8), rings=24), diffuse((0.8, 0.4, 0.3)))
    builder.add(quad((-1, -1, 4), (0, 2, 0), (2, 0, 0)), emission(6.0))
    builder.light("POINT", transform=placed(1.0, (3, -2, 3)), emission=(80.0,) * 3, radius=0.4)
    builder.description.world = background(0.2)
    return builder


def luminance_and_error(scene: Any, samples: int, seed: int) -> tuple[Array, Array, float]:
    session = engine_core.Session(
        scene, {"samples": samples, "seed": seed, "threads": 2}, ["Combined", "Error"]
    )
    session.start()
    while not session.wait(10.0):
        pass
    size = scene.width, scene.height
    color = np.asarray(session.read("Combined", 0, 0, *size), np.float64)[..., :3]
    error = np.asarray(session.read("Error", 0, 0, *size), np.float64)[..., 0]
    return color @ LUMINANCE, error, session.poll(True).error


def test_the_picture_s_error_is_the_percentile_of_the_error_pass() -> None:
    scene = engine_core.compile(smooth_scene().description, threads=2)
    for samples in (2, 16):
        _, errors, total = luminance_and_error(scene, samples, 1)
        assert total == pytest.approx(probe.picture_error(errors.ravel().tolist()), rel=1e-6)


@pytest.mark.parametrize("samples", [16, 48])
def test_95_in_100_pixels_lie_within_their_stated_error(samples: int) -> None:
    scene = engine_core.compile(smooth_scene().description, threads=2)
    truth, reference_error, _ = luminance_and_error(scene, 2048, 1000)
    mean = truth.mean()
    seeds = 6
    inside, actual, stated = [], [], []
    for seed in range(seeds):
        value, error, _ = luminance_and_error(scene, samples, seed)
        half_width = error * np.maximum(abs(value), 0.01 * mean)
        slack = reference_error * np.maximum(truth, 0.01 * mean)
        # The reference is uncertain too: it shifts few pixels across the line, either way.
        assert np.median(slack) < 0.25 * np.median(half_width)
        inside.append(abs(value - truth) <= half_width)
        actual.append((value - truth) ** 2)
        stated.append(half_width**2)
    share = np.mean(inside)
    # Pixels share light paths' stratification, so the binomial bound is widened: the spread of the
    # share over seeds, and a margin for batches that are stratified better than single samples.
    shares = np.mean(inside, axis=(1, 2))
    error = shares.std(ddof=1) / math.sqrt(seeds)
    assert share > 0.93 - 4 * error
    # The batches are parts of one net: the statement is on the safe side here, but not by far.
    factor = probe.interval_factor(8 if samples == 16 else 16)
    assert math.sqrt(np.mean(stated) / np.mean(actual)) < 2.5 * factor
