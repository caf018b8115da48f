"""A film is right after as many samples as there may be, and its statistics do not cancel."""

from __future__ import annotations

import numpy as np
import pytest

from engine_core import probe


@pytest.mark.parametrize("value", [0.1, 1e-30, 3e30])
def test_sums_of_ten_million_samples_are_rounded_once(value: float) -> None:
    """In float32 the pass of these sums would be off by some thousandths."""
    combined, emission, count = probe.accumulated(value, 64, 1 << 18)
    assert count == 1 << 24
    assert combined == pytest.approx(np.float32(value), rel=1.2e-7)
    assert emission == pytest.approx(np.float32(value), rel=1.2e-7)


@pytest.mark.thorough
def test_sums_of_a_thousand_million_samples_are_rounded_once() -> None:
    combined, emission, count = probe.accumulated(0.1, 64, 1_000_000_000 // 64)
    assert count == pytest.approx(1e9)
    assert combined == pytest.approx(np.float32(0.1), rel=1.2e-7)
    assert emission == pytest.approx(np.float32(0.1), rel=1.2e-7)


@pytest.mark.parametrize("spread", [1.0, 1e-3, 1e-5, 1e-6])
@pytest.mark.parametrize("level", [1e-20, 1.0, 1e20])
def test_variances_far_below_the_mean_are_kept(level: float, spread: float) -> None:
    """Down to the rounding of the 32-bit samples themselves."""
    deviations = np.random.default_rng(5).normal(size=2000)
    means = level * (1.0 + spread * deviations)
    row = np.array(probe.pixel_estimate((8 * means).tolist(), [8] * len(means)))
    truth = means.std(ddof=1) / np.sqrt(len(means))
    assert np.sqrt(row[1]) == pytest.approx(truth, rel=1e-2)
