"""Statistical tests whose false alarms have a stated probability.

Every test file uses fixed seeds, so a test that passes goes on passing; the significance level
only bounds how likely a correct program was to fail when the seeds were chosen.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]

#: Chance of a false alarm of one test, over all comparisons it makes (Sidak).
SIGNIFICANCE = 1e-4


def sidak(count: int, significance: float = SIGNIFICANCE) -> float:
    """The level of each of `count` comparisons that gives `significance` to all together."""
    return float(-np.expm1(np.log1p(-significance) / count))


def block_means(pictures: Array, block: int) -> Array:
    """Means over blocks of pixels and colours: (seeds, blocks)."""
    n, h, w = pictures.shape[:3]
    h, w = h - h % block, w - w % block
    cut = pictures[:, :h, :w].reshape(n, h // block, block, w // block, block, -1)
    return cut.mean(axis=(2, 4, 5)).reshape(n, -1)


def assert_equal_means(a: Array, b: Array, block: int = 4) -> None:
    """Welch's test between two stacks of independent pictures, block by block.

    `a` and `b` are (seeds, height, width, channels). Averages over blocks are near normal.
    """
    x, y = block_means(a, block), block_means(b, block)
    nx, ny = len(x), len(y)
    vx, vy = x.var(axis=0, ddof=1) / nx, y.var(axis=0, ddof=1) / ny
    # Rounding of float32 pictures: where both are noise-free they need not agree to the last bit.
    rounding = (4 * np.finfo(np.float32).eps * np.maximum(abs(x.mean(0)), abs(y.mean(0)))) ** 2
    total = vx + vy + rounding
    freedom = total**2 / (vx**2 / (nx - 1) + vy**2 / (ny - 1) + rounding**2 + 1e-300)
    t = (x.mean(axis=0) - y.mean(axis=0)) / np.sqrt(np.maximum(total, 1e-300))
    p = 2 * stats.t.sf(abs(t), np.clip(freedom, 1, 1e6))
    worst = int(p.argmin())
    assert p[worst] > sidak(p.size), (
        f"block {worst}: {x.mean(0)[worst]:.6g} against {y.mean(0)[worst]:.6g}, p = {p[worst]:.2g}"
    )


def assert_mean_is(samples: Array, truth: float | Array, tolerance: float = 0.0) -> None:
    """A t-test of independent samples (seeds, ...) against the truth.

    `tolerance` is a relative model error that the truth itself has (a faceted sphere, say).
    """
    flat = samples.reshape(len(samples), -1)
    goal = np.broadcast_to(np.asarray(truth, np.float64), samples.shape[1:]).reshape(-1)
    mean, error = flat.mean(axis=0), flat.std(axis=0, ddof=1) / np.sqrt(len(flat))
    slack = tolerance * abs(goal) + 4 * np.finfo(np.float32).eps * abs(goal)
    excess = np.maximum(abs(mean - goal) - slack, 0.0)
    p = 2 * stats.t.sf(excess / np.maximum(error, 1e-300), len(flat) - 1)
    p = np.where(excess == 0.0, 1.0, p)
    worst = int(p.argmin())
    assert p[worst] > sidak(p.size), (
        f"mean {mean[worst]:.6g} +- {error[worst]:.2g} against {goal[worst]:.6g}, "
        f"p = {p[worst]:.2g}"
    )


def assert_chi_squared(observed: Array, expected: Array, minimum: float = 5.0) -> None:
    """Pearson's test of counts against expected counts; sparse cells are pooled."""
    order = np.argsort(expected.ravel())
    o, e = observed.ravel()[order], expected.ravel()[order]
    pooled_o, pooled_e, held_o, held_e = [], [], 0.0, 0.0
    for oi, ei in zip(o, e, strict=True):
        held_o, held_e = held_o + oi, held_e + ei
        if held_e >= minimum:
            pooled_o.append(held_o)
            pooled_e.append(held_e)
            held_o = held_e = 0.0
    if pooled_e:
        pooled_o[-1] += held_o
        pooled_e[-1] += held_e
    a, b = np.array(pooled_o), np.array(pooled_e)
    statistic = float(((a - b) ** 2 / b).sum())
    p = float(stats.chi2.sf(statistic, max(len(a) - 1, 1)))
    assert p > SIGNIFICANCE, f"chi-squared {statistic:.1f} over {len(a)} cells, p = {p:.2g}"
