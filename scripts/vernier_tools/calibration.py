"""Whether error bars are true: their arithmetic.

Arrays are of luminances, by run, row and column. `truth` is a long render, and `slack` its own
stated half-width: what is within the bar of one and of the other, in quadrature, counts as within.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: As engine_core/accuracy/statement.h has them.
CONFIDENCE, FLOOR, PERCENTILE = 0.95, 0.01, 0.95
NORMAL_QUANTILE = 1.959963984540054
RADIUS = 3  # of neighbourhoods, pixels


def scale(values: Array) -> Array:
    """What errors of a picture are relative to: its values, or 1 % of their mean."""
    floor = FLOOR * np.abs(values.mean(axis=(-2, -1), keepdims=True))
    return np.asarray(np.maximum(np.abs(values), floor))


def coverage(values: Array, halves: Array, truth: Array, slack: Array) -> float:
    """The share of pixels within their stated half-widths, over all runs."""
    return float(np.mean(np.abs(values - truth) <= np.hypot(halves, slack)))


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
    """The picture's error: the 95th percentile of its pixels' half-widths."""
    return float(np.quantile(true_half_widths(values, truth, slack), PERCENTILE))


def deviation(values: Array, truth: Array, slack: Array) -> float:
    """The root of the relative squared error that 95 in 100 neighbourhoods of 7 by 7 pixels do not
    exceed, over all runs. Unlike a quantile over renders it falls with the root of the samples
    whatever the tail. The reference's own is taken off."""
    squares = (((values - truth) / scale(truth)) ** 2).mean(axis=0)
    own = (slack / scale(truth)) ** 2 / NORMAL_QUANTILE**2
    radius = min(RADIUS, *(side - 1 for side in truth.shape))
    around = [
        np.lib.stride_tricks.sliding_window_view(
            np.pad(each, radius, mode="reflect"), (2 * radius + 1, 2 * radius + 1)
        ).mean(axis=(2, 3))
        for each in (squares, np.minimum(own, squares))
    ]
    return float(np.sqrt(np.quantile(around[0] - around[1], PERCENTILE)))


def bias(values: Array, truth: Array) -> tuple[float, float]:
    """Of the picture's mean over the runs, relative to the truth's, and its standard error."""
    means = values.mean(axis=(1, 2)) / truth.mean()
    error = means.std(ddof=1) / np.sqrt(len(means)) if len(means) > 1 else np.nan
    return float(means.mean() - 1.0), float(error)
