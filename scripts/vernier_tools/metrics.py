"""How far two renders are apart, and how much of that their noise explains.

A render comes as two independent halves of equal size. Their mean is the picture; half their
difference is, squared, an unbiased estimate of the picture's variance at each pixel (for two
independent X and Y of variance 2v, the mean (X + Y) / 2 has variance v = E[(X - Y)^2] / 4).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from vernier_tools.images import FloatImage, block_sums, luminance

# Share of the mean squared reference in the denominator: keeps black pixels from ruling the mean.
FLOOR = 0.01


def relative_squared_error(image: FloatImage, reference: FloatImage) -> float:
    """Mean over pixels and channels of (I - R)^2 / (R^2 + 0.01 mean(R)^2)."""
    return weighted_mean_square(np.asarray(image, np.float64) - reference, reference)


def relative_noise(halves: tuple[FloatImage, FloatImage], reference: FloatImage) -> float:
    """The part of the error of the halves' mean that is noise, in the same measure."""
    return weighted_mean_square((np.asarray(halves[0], np.float64) - halves[1]) / 2, reference)


def share_of_the_worst(image: FloatImage, reference: FloatImage, worst: float = 0.001) -> float:
    """The share of the relative squared error that the worst pixels (one in 1000) carry.

    Where it is large, the error is one of few bright pixels, and another render's may be far off.
    """
    errors = weighted_squares(np.asarray(image, np.float64) - reference, reference).sum(axis=2)
    ordered = np.sort(errors, axis=None)
    total = float(ordered.sum())
    count = math.ceil(worst * ordered.size)
    return float(ordered[-count:].sum()) / total if total > 0 else 0.0


def weighted_mean_square(difference: NDArray[np.float64], reference: FloatImage) -> float:
    return float(np.mean(weighted_squares(difference, reference)))


def weighted_squares(difference: NDArray[np.float64], reference: FloatImage) -> NDArray[np.float64]:
    r = np.asarray(reference, np.float64)
    return np.asarray(difference**2 / (r**2 + FLOOR * np.mean(r) ** 2))


@dataclass(frozen=True)
class Agreement:
    """Whether two pictures have the same mean, and the same mean in every block of pixels.

    `ratio` is mean luminance of the first over that of the second, `ratio_error` its standard
    error. `block_z` holds each block's difference in standard errors. `worst_z` is the largest of
    these by size, `probability` the chance of one as large or larger among all blocks if nothing
    but noise sets the pictures apart (Sidak: 1 - (1 - p)^n).
    """

    ratio: float
    ratio_error: float
    block: int
    block_z: NDArray[np.float64]
    worst_z: float
    probability: float


def agreement(
    first: tuple[FloatImage, FloatImage], second: tuple[FloatImage, FloatImage], block: int = 16
) -> Agreement:
    """Compares two renders given as independent halves."""
    a, b = (luminance(np.asarray((half[0] + half[1]) / 2, np.float32)) for half in (first, second))
    variances = [(luminance(half[0]) - luminance(half[1])) ** 2 / 4 for half in (first, second)]
    mean_a, mean_b = float(a.mean(dtype=np.float64)), float(b.mean(dtype=np.float64))
    count = a.size
    errors = [math.sqrt(float(v.sum(dtype=np.float64))) / count for v in variances]
    ratio = mean_a / mean_b if mean_b else math.nan
    relative = [e / m if m else math.nan for e, m in zip(errors, (mean_a, mean_b), strict=True)]
    block = min(block, *a.shape)
    difference = block_sums(np.asarray(a - b, np.float32), block)
    spread = np.sqrt(block_sums(np.asarray(variances[0] + variances[1], np.float32), block))
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(difference == 0, 0.0, difference / spread)
    worst = float(np.abs(z).max())
    # log1p and expm1 keep the digits of probabilities far below one.
    single = special.erfc(worst / math.sqrt(2))
    probability = -math.expm1(z.size * math.log1p(-single)) if single < 1 else 1.0
    return Agreement(
        ratio=ratio,
        ratio_error=abs(ratio) * math.hypot(*relative),
        block=block,
        block_z=z,
        worst_z=worst,
        probability=probability,
    )
