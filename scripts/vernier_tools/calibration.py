"""Whether error bars are true: their arithmetic.

Arrays are of luminances, by run, row and column. `truth` is a long render, and `slack` its own
stated half-width: what is within the bar of one and of the other, in quadrature, counts as within.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: As engine_core/accuracy/statement.h has them.
CONFIDENCE, FLOOR, PERCENTILE = 0.95, 0.01, 0.95
NORMAL_QUANTILE = 1.959963984540054
RADIUS = 3  # of neighbourhoods, pixels
DEVIATIONS = 4.0  # what noise explains
LEAST_RUNS_TO_HALVE = 4
SAME = 1e-5  # relative: what float32 pictures of one value differ by


def scale(values: Array) -> Array:
    """What errors of a picture are relative to: its values, or 1 % of their mean."""
    floor = FLOOR * np.abs(values.mean(axis=(-2, -1), keepdims=True))
    return np.asarray(np.maximum(np.abs(values), floor))


def coverage(values: Array, halves: Array, truth: Array, slack: Array) -> float:
    """The share of pixels within their stated half-widths, over all runs.

    Those that are the same in every render, as those of a plain sky are, tell nothing and do not
    count; NaN where all are.
    """
    errors = np.abs(values - truth)
    vary = (errors > SAME * scale(truth)).any(axis=0)
    if not vary.any():
        return math.nan
    return float(np.mean((errors <= np.hypot(halves, slack))[:, vary]))


def true_half_widths(values: Array, truth: Array, slack: Array) -> Array:
    """Relative: the error that 95 in 100 renders of a pixel do not exceed, by row and column.

    Few runs know little of a quantile, and the percentile over the picture of many such would pick
    the unluckiest: so it is that over all runs and the 7 by 7 pixels around. The reference's own is
    taken off in quadrature.
    """
    errors = np.abs(values - truth) / scale(truth)
    radius = min(RADIUS, *(side - 1 for side in truth.shape))
    edge, side = (radius, radius), 2 * radius + 1
    padded = np.pad(errors, ((0, 0), edge, edge), mode="reflect")
    around = np.lib.stride_tricks.sliding_window_view(padded, (side, side), axis=(1, 2))
    sample = np.moveaxis(around, 0, -1).reshape(*truth.shape, -1)
    width = np.quantile(sample, CONFIDENCE, axis=-1)
    own = np.minimum(slack / scale(truth), width)
    return np.asarray(np.sqrt(width**2 - own**2))


def true_error(values: Array, truth: Array, slack: Array) -> float:
    """The picture's error: the 95th percentile of its pixels' half-widths.

    A percentile of uncertain half-widths picks the unluckiest: it comes out too large by about what
    they are uncertain, which falls with the root of the number of runs. What half of the runs find
    tells by how much, and it is taken off.
    """

    def percentile(runs: Array) -> float:
        return float(np.quantile(true_half_widths(runs, truth, slack), PERCENTILE))

    whole = percentile(values)
    if len(values) < LEAST_RUNS_TO_HALVE:
        return whole
    halves = 0.5 * (percentile(values[::2]) + percentile(values[1::2]))
    return whole - max(0.0, halves - whole) / (math.sqrt(2.0) - 1.0)


def windows(values: Array) -> Array:
    """The 7 by 7 pixels around each, in a last dimension."""
    radius = min(RADIUS, *(side - 1 for side in values.shape[-2:]))
    margin = [(0, 0)] * (values.ndim - 2) + [(radius, radius)] * 2
    side = 2 * radius + 1
    around = np.lib.stride_tricks.sliding_window_view(
        np.pad(values, margin, mode="reflect"), (side, side), axis=(-2, -1)
    )
    return np.asarray(around.reshape(*values.shape, side * side))


def lacking(values: Array, truth: Array, slack: Array) -> Array:
    """Relative light that the renders of a method have not met though the truth has it, beyond what
    noise explains: means around each pixel, by row and column."""
    noise = values.var(axis=0, ddof=1) / len(values) + (slack / NORMAL_QUANTILE) ** 2
    gap = windows((truth - values.mean(axis=0)) / scale(truth)).mean(axis=-1)
    around = windows(noise / scale(truth) ** 2)
    return np.asarray(
        np.maximum(gap - DEVIATIONS * np.sqrt(around.mean(axis=-1) / around.shape[-1]), 0.0)
    )


def deviation(values: Array, truth: Array, slack: Array) -> float:
    """The root of the relative squared error that 95 in 100 neighbourhoods of 7 by 7 pixels do not
    exceed. Unlike a quantile over renders it falls with the root of the samples whatever the tail.

    It is from what two renders or more differ by: a bright dot of the reference is no error of
    theirs. Light that they all lack counts in full.
    """
    squares = windows(values.var(axis=0, ddof=1) / scale(truth) ** 2).mean(axis=-1)
    return float(np.sqrt(np.quantile(squares + lacking(values, truth, slack) ** 2, PERCENTILE)))


def usual_error(values: Array, truth: Array, slack: Array) -> float:
    """The picture's error by its definition, from what two renders or more differ by: for every
    pixel the difference that 95 in 100 pairs do not exceed, over the 7 by 7 pixels around, over
    the root of two, and light that all lack; of these the 95th percentile."""
    pairs = itertools.combinations(values, 2)
    gaps = np.array([np.abs(a - b) for a, b in pairs]) / (math.sqrt(2.0) * scale(truth))
    around = np.moveaxis(windows(gaps), 0, -2).reshape(*truth.shape, -1)
    widths = np.hypot(np.quantile(around, CONFIDENCE, axis=-1), lacking(values, truth, slack))
    return float(np.quantile(widths, PERCENTILE))


def bias(values: Array, truth: Array) -> tuple[float, float]:
    """Of the picture's mean over the runs, relative to the truth's, and its standard error."""
    means = values.mean(axis=(1, 2)) / truth.mean()
    error = means.std(ddof=1) / np.sqrt(len(means)) if len(means) > 1 else np.nan
    return float(means.mean() - 1.0), float(error)
