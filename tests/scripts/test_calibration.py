"""Calibration and choices: their arithmetic, and what a scene's requirements are told to be."""

from __future__ import annotations

import argparse
import math

import numpy as np
import pytest
from vernier_tools import arguments, calibrate, calibration, methods, progress_page
from vernier_tools.core_renders import CoreRender
from vernier_tools.jobs import Render

SHAPE = (12, 20)


def noisy(rng: np.random.Generator, runs: int, deviation: float) -> calibration.Array:
    return np.asarray(2.0 * (1.0 + deviation * rng.normal(size=(runs, *SHAPE))))


def test_normal_bars_cover_95_in_100(rng: np.random.Generator) -> None:
    values, truth = noisy(rng, 64, 0.1), np.full(SHAPE, 2.0)
    halves = np.full_like(values, 1.96 * 0.2)
    assert calibration.coverage(values, halves, truth, 0.0 * truth) == pytest.approx(0.95, abs=0.01)
    assert calibration.coverage(values, 0.5 * halves, truth, 0.0 * truth) < 0.75
    # A reference that is as uncertain counts as the bar does.
    other = noisy(rng, 64, 0.1)
    both = calibration.coverage(values, halves, other, halves)
    assert both == pytest.approx(0.95, abs=0.01)


def test_pixels_that_never_vary_say_nothing_of_bars(rng: np.random.Generator) -> None:
    values, truth = noisy(rng, 64, 0.1), np.full(SHAPE, 2.0)
    values[:, :, :15] = np.float32(2.0 + 1e-6)
    halves = np.full_like(values, 1.96 * 0.2)
    assert calibration.coverage(values, halves, truth, 0.0 * truth) == pytest.approx(0.95, abs=0.02)
    assert math.isnan(calibration.coverage(0.0 * values + truth, halves, truth, 0.0 * truth))


def test_the_true_error_is_the_quantile_over_renders(rng: np.random.Generator) -> None:
    truth = np.full(SHAPE, 2.0)
    values = noisy(rng, 64, 0.1)
    assert calibration.true_error(values, truth, 0.0 * truth) == pytest.approx(0.196, rel=0.03)
    # So do few, whose percentile is of the unluckiest pixels, but for what halves of them tell.
    few = [
        calibration.true_error(values[first : first + 8], truth, 0.0 * truth)
        for first in range(0, 64, 8)
    ]
    assert np.mean(few) == pytest.approx(0.196, rel=0.05)
    # A pixel that is wrong in one render of fifty is not wrong in 95 of 100.
    values[0] += 100.0
    assert calibration.true_error(values, truth, 0.0 * truth) < 0.3
    # What the reference does not know itself is taken off.
    wider = calibration.true_error(values, truth, np.full(SHAPE, 0.3))
    assert wider < calibration.true_error(values, truth, 0.0 * truth)


def test_dark_pixels_are_relative_to_a_hundredth_of_the_mean() -> None:
    values = np.array([[0.0, 1.0], [2.0, -1.0]])
    assert calibration.scale(values).tolist() == [[0.005, 1.0], [2.0, 1.0]]


def test_bias_is_that_of_the_mean(rng: np.random.Generator) -> None:
    values, truth = 1.05 * noisy(rng, 100, 0.1), np.full(SHAPE, 2.0)
    bias, error = calibration.bias(values, truth)
    assert abs(bias - 0.05) < 4.0 * error < 0.01
    assert math.isnan(calibration.bias(values[:1], truth)[1])


def test_batches_are_samples() -> None:
    assert calibrate.limits("16", "PATH") == {"samples": 32}
    assert calibrate.limits("64", "PATH") == {"samples": 2560}
    assert calibrate.limits("16", "BDPT") == {"samples": 16}
    assert calibrate.limits("target=5", "BDPT") == {"target_error": 5.0}
    assert calibrate.limits("time=1.5", "PATH") == {"time_limit": 1.5}


@pytest.mark.parametrize("text", ["x", "target=0", "speed=3", "0", "16,"])
def test_bad_rules_are_told(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError):
        arguments.stopping_rules(text)


@pytest.mark.parametrize("text", ["40,8", "8,8", "8,x"])
def test_samples_of_a_progress_rise(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError):
        arguments.rising_ints(text)


def test_a_calibration_is_a_table() -> None:
    row = calibrate.Row("box", "PATH", "16", 8, 32.0, 0.5, 0.951, 0.22, 0.2, 1e-3, 2e-3)
    text = calibrate.markdown([row])
    cells = "| `box` | `path` | 16 | 32 | 95.1 | 22 % | 20 % | 1.10 | +0.10 ± 0.20 |"
    assert text.splitlines()[-1] == cells


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.01234, "1.23 %"), (10.8, "1080 %"), (9.996, "1000 %"), (math.inf, "inf %")],
)
def test_percentages_have_no_exponent(value: float, text: str) -> None:
    assert calibrate.percent(value) == text


def measured(pictures: calibration.Array, preparation: float = 0.0) -> methods.Measured:
    """Renders of three seconds."""
    runs = [
        CoreRender(values, 0.0 * values, 0.1, 16.0, 3.0, "time", "PATH", "") for values in pictures
    ]
    return methods.Measured(runs, preparation)


def test_the_time_to_an_error_goes_with_its_square(rng: np.random.Generator) -> None:
    truth = np.full(SHAPE, 2.0)
    reference = measured(truth[None]).runs[0]
    pictures = noisy(rng, 64, 0.1)
    runs = measured(pictures)
    at_once = methods.seconds_to(0.2, runs, reference)
    assert at_once == pytest.approx(3.0, rel=0.25)
    assert methods.seconds_to(0.1, runs, reference) == pytest.approx(4.0 * at_once)
    # What comes before the first sample comes once.
    assert methods.seconds_to(0.1, measured(pictures, 1.5), reference) == pytest.approx(
        1.5 + 2.0 * at_once
    )
    # Errors are normal: what 95 in 100 do not exceed is 1.96 deviations.
    assert methods.usual_seconds_to(0.2, runs, reference) == pytest.approx(at_once, rel=0.1)


def test_a_reference_s_dot_is_no_error_but_light_that_all_lack_is(
    rng: np.random.Generator,
) -> None:
    truth, pictures = np.full(SHAPE, 2.0), noisy(rng, 8, 0.1)
    slack = np.zeros(SHAPE)
    usual, deviation = (
        error(pictures, truth, slack) for error in (calibration.usual_error, calibration.deviation)
    )
    dotted = truth.copy()
    dotted[5, 5] = 200.0
    # It says nothing of its own error, and is one pixel of many.
    slack[5, 5] = 1.96 * 198.0
    assert calibration.usual_error(pictures, dotted, slack) == pytest.approx(usual, rel=0.02)
    assert calibration.deviation(pictures, dotted, slack) == pytest.approx(deviation, rel=0.02)
    dark = pictures.copy()
    dark[:, :8] *= 0.5
    assert calibration.deviation(dark, truth, 0.0 * truth) > 4.0 * deviation
    assert calibration.usual_error(dark, truth, 0.0 * truth) > 2.0 * usual
    reference = measured(truth[None]).runs[0]
    assert math.isfinite(methods.usual_seconds_to(0.1, measured(pictures), reference))
    assert math.isinf(methods.usual_seconds_to(0.1, measured(dark), reference))
    assert methods.told(math.inf) == "–"


def test_how_uncertain_a_time_is_falls_with_the_number_of_renders(
    rng: np.random.Generator,
) -> None:
    reference = measured(np.full((1, *SHAPE), 2.0)).runs[0]

    def uncertain(count: int) -> float:
        return methods.uncertainty(measured(noisy(rng, count, 0.1)), reference)

    assert math.isnan(uncertain(2))
    assert 0.0 < uncertain(64) < uncertain(4) < 0.5


def test_a_choice_is_compared_with_the_best() -> None:
    seconds, usual = {"PATH": 2.0, "BDPT": 3.0}, {"PATH": 4.0, "BDPT": 2.0}
    row = methods.Row("box", seconds, {"PATH": 0.1, "BDPT": 0.2}, usual, "BDPT", "so")
    assert row.times_best(seconds) == pytest.approx(1.5)
    cells = "| `box` | 2 ± 10 % / 4 | 3 ± 20 % / 2 | `bdpt` | 1.50 / 1.00 |"
    assert cells in methods.methods_table([row])
    adaptive = methods.Adaptive("box", 5.0, 3.0, 6.0, 0.05, 0.05)
    assert "| `box` | 5 % | 3 | 6 | 0.50 |" in methods.adaptive_table([adaptive])


def test_steps_of_a_progress_tell_time_and_error() -> None:
    def step(samples: float, error: float) -> Render:
        return Render(0, 2.0, 2.0, 2.0, 0.1, 0.2, 1.5, samples, 1, 1, 0, error)

    lines = progress_page.captions([step(8, math.inf), step(40, 0.123)])
    assert lines == [
        "8 samples per pixel, 1.5 s, error unknown",
        "40 samples per pixel, 3.0 s, error 12 %",
    ]
