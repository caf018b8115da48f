"""The measures of difference, against values known in closed form and by statistics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from vernier_tools import images, metrics

SHAPE = (96, 128, 3)

Halves = tuple[NDArray[np.float32], NDArray[np.float32]]


def noisy(mean: float, sigma: float, seed: int) -> Halves:
    """Two halves of a render whose mean has standard deviation `sigma` at each value."""
    rng = np.random.default_rng(seed)
    first, second = (
        rng.normal(mean, sigma * math.sqrt(2), SHAPE).astype(np.float32) for _ in range(2)
    )
    return first, second


def mean_of(halves: Halves) -> NDArray[np.float32]:
    return np.asarray((halves[0] + halves[1]) / 2, np.float32)


def test_relative_squared_error_of_a_constant_offset() -> None:
    reference = np.full(SHAPE, 2.0, np.float32)
    error = metrics.relative_squared_error(reference + 0.5, reference)
    assert error == pytest.approx(0.25 / (4 + 0.04), rel=1e-6)


def test_black_pixels_are_weighed_by_the_mean_of_the_picture() -> None:
    reference = np.zeros(SHAPE, np.float32)
    reference[:48] = 2.0
    image = reference.copy()
    image[48:] = 0.1
    # Half of the pixels are off by 0.1 where the reference is black and its mean is 1.
    error = metrics.relative_squared_error(image, reference)
    floor = 0.01 * 1.0**2
    assert error == pytest.approx(0.5 * 0.1**2 / floor, rel=1e-5)


def test_noise_is_estimated_without_bias() -> None:
    reference = np.full(SHAPE, 1.0, np.float32)
    halves = noisy(1.0, 0.2, seed=1)
    expected = 0.2**2 / 1.01
    # A sum of n squared normal variables has relative standard deviation sqrt(2 / n).
    bound = 5 * math.sqrt(2 / reference.size)
    assert metrics.relative_noise(halves, reference) == pytest.approx(expected, rel=bound)
    error = metrics.relative_squared_error(mean_of(halves), reference)
    assert error == pytest.approx(expected, rel=bound)


def test_pictures_that_differ_by_noise_alone_agree() -> None:
    agree = metrics.agreement(noisy(1.0, 0.3, seed=2), noisy(1.0, 0.2, seed=3))
    assert abs(agree.ratio - 1) < 5 * agree.ratio_error
    assert agree.probability > 1e-4
    # Luminance sums three independent channels: its variance is sigma^2 times the squared weights.
    spread = math.sqrt(float((images.LUMINANCE**2).sum()))
    count = SHAPE[0] * SHAPE[1]
    expected = spread * math.hypot(0.3, 0.2) / math.sqrt(count)
    assert agree.ratio_error == pytest.approx(expected, rel=0.05)


def test_a_small_difference_in_one_place_is_found() -> None:
    first, second = noisy(1.0, 0.2, seed=4), noisy(1.0, 0.2, seed=5)
    for half in first:
        half[16:32, 32:48] += 0.15
    agree = metrics.agreement(first, second)
    assert agree.probability < 1e-6
    assert abs(agree.block_z[1, 2]) == agree.worst_z


def test_block_z_is_a_standard_normal_variable() -> None:
    z = metrics.agreement(noisy(1, 0.2, seed=6), noisy(1, 0.2, seed=7), block=8).block_z
    count = z.size
    assert abs(z.mean()) < 5 / math.sqrt(count)
    assert float(z.var()) == pytest.approx(1.0, abs=5 * math.sqrt(2 / count))


def test_equal_and_black_pictures_give_finite_figures() -> None:
    black = np.zeros(SHAPE, np.float32)
    agree = metrics.agreement((black, black), (black, black))
    assert agree.worst_z == 0
    assert agree.probability == 1
    ones = black + 1
    assert metrics.agreement((ones, ones), (ones, ones)).ratio == 1


def test_the_sidak_probability_of_many_blocks() -> None:
    agree = metrics.agreement(noisy(1, 0.2, seed=8), noisy(1, 0.2, seed=9))
    single = math.erfc(agree.worst_z / math.sqrt(2))
    assert agree.probability == pytest.approx(1 - (1 - single) ** agree.block_z.size, rel=1e-6)


def test_the_worst_pixels_share_of_the_error_is_known() -> None:
    reference = np.ones((40, 50, 3), np.float32)
    image = reference + np.float32(0.1)
    assert metrics.share_of_the_worst(image, reference) == pytest.approx(0.001, rel=1e-3)
    image[7, 9] = 101.0
    assert metrics.share_of_the_worst(image, reference) > 0.99
    assert metrics.share_of_the_worst(reference, reference) == 0.0
