"""Judges the independent pictures of a case: a figure for the report, and a verdict."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from extreme_cases.case import AtMost, Dark, Expectation, Same, Truth
from numpy.typing import NDArray
from scipy import stats
from statistics_tools import block_means, sidak

Array = NDArray[np.float64]

#: Chance that a correct program fails one case. The suite has about a thousand.
SIGNIFICANCE = 1e-6
FLOAT32_ROUNDING = 4 * float(np.finfo(np.float32).eps)


@dataclass(frozen=True)
class Shots:
    """Independent pictures of one scene: (pictures, height, width, 3), and what went wrong."""

    pictures: Array
    samples: float
    dropped: int
    message: str = ""


@dataclass(frozen=True)
class Verdict:
    passed: bool
    #: What was measured, in words.
    figure: str
    #: In numbers: a relative deviation (of `Dark`, a radiance), and its standard error.
    value: float
    error: float = 0.0


def common(shots: Shots) -> str:
    """What is wrong with the pictures in themselves, or nothing."""
    if shots.message:
        return f"ended with: {shots.message}"
    if not np.isfinite(shots.pictures).all():
        return "a value is not finite"
    if (shots.pictures < 0).any():
        return f"negative radiance {shots.pictures.min():.2g}"
    if shots.dropped:
        return f"{shots.dropped} samples dropped of {shots.samples:.3g}"
    return ""


def mean_and_error(samples: Array) -> tuple[Array, Array]:
    """Over the first axis: means and their standard errors.

    Few pictures tell little of the error of each part, and nothing where rare bright samples are
    yet to come. So each is taken as half its own and half the mean of all parts (as variances).
    """
    mean = samples.mean(axis=0)
    if len(samples) < 2:
        return mean, np.zeros_like(mean)
    # Deviations that float32 cannot hold are none.
    scale = np.maximum(np.abs(samples).max(axis=0), np.finfo(np.float64).tiny)
    own = scale * (samples / scale).std(axis=0, ddof=1) / np.sqrt(len(samples))
    largest = max(float(own.max()), np.finfo(np.float64).tiny)
    shared = largest * np.sqrt(np.mean((own / largest) ** 2))
    return mean, np.hypot(own, shared) / np.sqrt(2)


def freedom(pictures: int, parts: int) -> int:
    """Degrees of freedom of such an error, at the least."""
    return max(pictures - 1, 1) * (1 + min(parts, 8) // 2)


def excesses(difference: Array, error: Array, allowed: Array | float, freedom: int) -> float:
    """The least probability, over all, of a difference beyond what is allowed."""
    beyond = np.maximum(difference - allowed, 0.0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        t = np.where(beyond > 0, beyond / error, 0.0)
    return float((2 * stats.t.sf(t, freedom)).min())


def against_value(shots: Shots, value: float, tolerance: float, upper: bool) -> Verdict:
    pictures = shots.pictures
    whole = pictures.mean(axis=(1, 2, 3))[:, None]
    pixels = pictures.mean(axis=3).reshape(len(pictures), -1)
    passed = True
    worst = 0.0
    for samples in (whole, pixels):
        mean, error = mean_and_error(samples)
        difference = mean - value if upper else np.abs(mean - value)
        p = excesses(
            difference,
            error,
            (tolerance + FLOAT32_ROUNDING) * value,
            freedom(len(samples), mean.size),
        )
        passed = passed and p >= sidak(mean.size, SIGNIFICANCE)
        if samples is whole:
            worst = float(difference[0] / value) if value else float(difference[0])
            spread = float(error[0] / value) if value else float(error[0])
    return Verdict(passed, f"{worst:+.1e} off, error {spread:.0e}", worst, spread)


def against_other(shots: Shots, other: Shots, factor: float, slack: float) -> Verdict:
    a, b = shots.pictures / factor, other.pictures
    block = 4 if min(a.shape[1:3]) >= 8 else 1
    x, y = block_means(a, block), block_means(b, block)
    (mx, ex), (my, ey) = mean_and_error(x), mean_and_error(y)
    error = np.hypot(ex, ey)
    scale = np.maximum(np.abs(mx), np.abs(my))
    # What the whole picture's brightness leaves unresolved in its darkest parts is no difference.
    allowed = slack * (scale + scale.mean()) + FLOAT32_ROUNDING * scale
    p = excesses(np.abs(mx - my), error, allowed, freedom(len(x), mx.size))
    mean = max(float(my.mean()), np.finfo(np.float64).tiny)
    off = float(mx.mean() - my.mean()) / mean
    noise = float(np.sqrt((error**2).mean() / error.size)) / mean
    whole = excesses(
        np.abs(mx.mean(keepdims=True) - my.mean(keepdims=True)),
        np.hypot(*(mean_and_error(side.mean(axis=1)[:, None])[1] for side in (x, y))),
        (2 * slack + FLOAT32_ROUNDING) * max(float(mx.mean()), float(my.mean())),
        freedom(len(x), 1),
    )
    passed = min(p, whole) >= sidak(mx.size + 1, SIGNIFICANCE)
    return Verdict(passed, f"{off:+.1e} off, error {noise:.0e}", off, noise)


def judge(
    expects: Expectation, shots: Shots, other: Callable[[Same], Shots], bias: float
) -> Verdict:
    """`other` renders the scene that a picture is compared with; `bias` is the method's own."""
    wrong = common(shots)
    if wrong:
        return Verdict(False, wrong, np.inf)
    if isinstance(expects, Truth):
        return against_value(shots, expects.value, expects.tolerance + bias, upper=False)
    if isinstance(expects, AtMost):
        return against_value(shots, expects.value, expects.tolerance + bias, upper=True)
    if isinstance(expects, Same):
        reference = other(expects)
        wrong = common(reference)
        if wrong:
            return Verdict(False, f"the other picture: {wrong}", np.inf)
        return against_other(shots, reference, expects.factor, expects.slack + bias)
    if isinstance(expects, Dark):
        worst = float(shots.pictures.max())
        return Verdict(worst == 0.0, f"brightest {worst:.1e}", worst)
    return Verdict(True, f"{shots.samples:.3g} samples", 0.0)
