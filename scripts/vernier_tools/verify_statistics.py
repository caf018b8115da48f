"""Whether two methods' pictures have the same expectation, as far as noise lets it be told.

A method comes as independent pictures. Their blocks of pixels, and their mean, are compared by
Welch's test, each colour on its own, with the variance of either side.

A standard error means something only where enough values carry it: of light that is so rarely found
that no picture of the sample has any, it says nothing. So each side's tail is measured: how many
values carry the variance, and the shape k of the generalised Pareto distribution of what the
brightest pixel values exceed a threshold by, after Zhang and Stephens (Technometrics 51, 2009)
and, as a diagnosis of means, Vehtari, Simpson, Gelman, Yao and Gabry (JMLR 25, 2024). From k = 1/2
on the variance is infinite. Where few values carry such a tail, a mean that is too small proves
nothing, for the rest of it may be in rarer values yet; one that is too large is the other side's to
explain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Chance that a comparison of two methods that agree fails, over all blocks and colours (Sidak).
SIGNIFICANCE = 1e-4
#: The shape from which on there is no variance.
HEAVY = 0.5
#: So many values tell a standard error to a tenth.
FEW = 30.0
#: Of float32 pictures that need not be equal to the last bit.
ROUNDING = 4 * float(np.finfo(np.float32).eps)


@dataclass(frozen=True)
class Sample:
    """Independent pictures of one method, by block: the last "block" is the whole picture.

    `means` is (pictures, blocks, colours); `heavy` (blocks,) tells where few values carry them.
    """

    means: Array
    heavy: Mask


@dataclass(frozen=True)
class Verdict:
    """What a comparison says.

    `ratio` is the whole picture's mean over the reference's, `ratio_error` its standard error,
    `spread` the median over the blocks of the standard error of the difference, over the reference.
    `worst` is the largest difference in standard errors among what could be decided, `probability`
    the chance of one such among as many. Of `blocks`, the whole among them, `undecided` could not
    be, and `failed` differ. `bias` is the relative difference that was let pass.
    """

    ratio: float
    ratio_error: float
    spread: float
    worst: float
    probability: float
    blocks: int
    undecided: int
    failed: int
    bias: float

    @property
    def word(self) -> str:
        if self.failed:
            return "DIFFERS"
        if 2 * self.undecided > self.blocks:
            return "undecided"
        return "agrees"


def tail_shape(values: Array) -> float:
    """The shape k of the tail of the positive `values`: the mean of its posterior as Zhang and
    Stephens approximate it, drawn to 1/2 by ten values' worth where there are few."""
    positive = np.sort(values[values > 0])
    count = int(min(0.2 * values.size, 3 * np.sqrt(values.size), positive.size - 1))
    if count < 5:
        return HEAVY if positive.size else 0.0  # too few carry the mean
    x = positive[-count:] - positive[-count - 1]
    if not x[-1] > 0 or not x[0] >= 0:
        return 0.0
    n = len(x)
    quartile = max(float(x[int(n / 4 + 0.5) - 1]), float(x[-1]) * 1e-6)
    m = 30 + int(np.sqrt(n))
    theta = 1 / x[-1] + (1 - np.sqrt(m / (np.arange(1, m + 1) - 0.5))) / (3 * quartile)
    k = np.log1p(-theta[:, None] * x).mean(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        profile = n * (np.log(-theta / k) - k - 1)
    profile = np.where(np.isfinite(profile), profile, -np.inf)
    weights = np.exp(profile - profile.max())
    best = float((weights * theta).sum() / weights.sum())
    shape = float(np.log1p(-best * x).mean())
    return (n * shape + 10 * HEAVY) / (n + 10)


def is_heavy(excess: Array) -> bool:
    """Whether few values, of a tail without a variance, carry the sum of `excess`."""
    largest = float(np.max(np.abs(excess)))
    if not largest > 0:
        return False
    squares = (excess / largest) ** 2
    carrying = float(squares.sum()) ** 2 / float((squares**2).sum())
    return carrying < FEW and tail_shape(excess) >= HEAVY


def block_masks(region: Mask, side: int) -> list[Mask]:
    """Of each block of which at least a quarter is in the region, that part; and the region."""
    height, width = region.shape
    masks = []
    for y in range(0, height, side):
        for x in range(0, width, side):
            block = np.zeros_like(region)
            block[y : y + side, x : x + side] = region[y : y + side, x : x + side]
            if 4 * block.sum() >= min(side, height - y) * min(side, width - x) > 0:
                masks.append(block)
    return [*masks, region]


def sample(pictures: NDArray[np.float32], masks: list[Mask], by_chance: bool = False) -> Sample:
    """`pictures` are (pictures, height, width, colours). `by_chance`: whatever they show of their
    tails, there is more beyond."""
    values = np.asarray(pictures, np.float64)
    # What a pixel has beyond its usual value: how bright a pixel is by right is no tail.
    excess = values.mean(axis=3) - np.median(values.mean(axis=3), axis=0)
    return Sample(
        np.stack([values[:, mask].mean(axis=1) for mask in masks], axis=1),
        np.array([by_chance or is_heavy(excess[:, mask].ravel()) for mask in masks]),
    )


def welch(a: Array, b: Array, allowed: Array) -> tuple[Array, Array, Array]:
    """Of the difference of two means, beyond what is allowed: its size in standard errors, the
    probability of as much by noise alone, and the standard error. Pictures are the first axis."""
    mean_a, mean_b = a.mean(axis=0), b.mean(axis=0)
    var_a, var_b = a.var(axis=0, ddof=1) / len(a), b.var(axis=0, ddof=1) / len(b)
    rounding = (ROUNDING * np.maximum(abs(mean_a), abs(mean_b))) ** 2
    variance = np.maximum(var_a + var_b + rounding, 1e-300)
    spread = var_a**2 / (len(a) - 1) + var_b**2 / (len(b) - 1) + rounding**2 + 1e-300
    freedom = np.clip(variance**2 / spread, 1.0, 1e6)
    error = np.sqrt(variance)
    excess = np.maximum(abs(mean_a - mean_b) - allowed, 0.0)
    z = np.asarray(np.copysign(excess, mean_a - mean_b) / error)
    return z, np.asarray(2 * stats.t.sf(abs(z), freedom)), error


def compare(method: Sample, reference: Sample, bias: float = 0.0) -> Verdict:
    """`bias` is the share of the reference's block, or of a tenth of the whole's mean where that is
    more, by which the method may be off."""
    a, b = method.means, reference.means
    mean = b.mean(axis=0)
    z, p, error = welch(a, b, bias * np.maximum(mean, 0.1 * mean[-1].mean()))
    # The side that is the smaller must have shown all that it has.
    smaller_is_heavy = np.where(z < 0, method.heavy[:, None], reference.heavy[:, None])
    level = -np.expm1(np.log1p(-SIGNIFICANCE) / p.size)
    differs = ((p < level) & ~smaller_is_heavy).any(axis=1)
    undecided = (method.heavy | reference.heavy) & ~differs
    judged = np.where(smaller_is_heavy | undecided[:, None], 1.0, p)
    worst = np.unravel_index(int(np.argmin(judged)), p.shape)
    chance = float(judged[worst])
    whole, whole_error = ratio(a[:, -1].mean(axis=1), b[:, -1].mean(axis=1))
    return Verdict(
        ratio=whole,
        ratio_error=whole_error,
        spread=float(np.median(error / np.maximum(mean, 1e-300))),
        worst=float(z[worst]) if chance < 1.0 else 0.0,
        probability=-math.expm1(p.size * math.log1p(-chance)) if chance < 1.0 else 1.0,
        blocks=len(p),
        undecided=int(undecided.sum()),
        failed=int(differs.sum()),
        bias=bias,
    )


def ratio(a: Array, b: Array) -> tuple[float, float]:
    """Of two means, with its standard error."""
    scale = max(float(b.mean()), 1e-300)
    value = float(a.mean()) / scale
    errors = [float(x.std(ddof=1)) / math.sqrt(len(x)) for x in (a, b)]
    return value, math.hypot(errors[0], value * errors[1]) / scale
