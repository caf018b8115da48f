"""When two renderers' pictures agree: their means within one per cent, and no block elsewhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from statistics_tools import sidak

Array = NDArray[np.float64]

#: Relative difference of the means that counts as agreement.
TOLERANCE = 0.01
#: The same of a block: the engines place edges and interpolate normals a little differently.
BLOCK_TOLERANCE = 0.03
#: A test whose standard error is above this share of the mean would pass whatever it sees.
POWER = 0.012


def _excess(a: Array, b: Array, tolerance: float, floor: float) -> tuple[Array, Array, Array]:
    """p-values (Welch) of |a - b| beyond a relative tolerance; samples along the first axis."""
    n, m = len(a), len(b)
    va, vb = a.var(axis=0, ddof=1) / n, b.var(axis=0, ddof=1) / m
    scale = np.maximum(np.maximum(abs(a.mean(axis=0)), abs(b.mean(axis=0))), floor)
    error = np.sqrt(va + vb)
    freedom = (va + vb) ** 2 / (va**2 / (n - 1) + vb**2 / (m - 1) + 1e-300)
    beyond = np.maximum(abs(a.mean(axis=0) - b.mean(axis=0)) - tolerance * scale, 0.0)
    p = 2.0 * stats.t.sf(beyond / np.maximum(error, 1e-30), np.clip(freedom, 1.0, 1e6))
    return np.where(beyond > 0.0, p, 1.0), error, scale


def assert_agreement(
    reference: Array,
    ours: Array,
    tolerance: float = TOLERANCE,
    block: int = 4,
    block_tolerance: float = BLOCK_TOLERANCE,
    power: float = POWER,
) -> None:
    """Holds two stacks of independent pictures, (seeds, height, width, channels), together.

    The mean of every channel must agree within `tolerance`, and so must every block of `block`
    pixels within `block_tolerance` (of the picture's mean, where the block is darker); beyond that
    the difference must be what noise makes (Welch's test, Sidak over all comparisons). The mean's
    standard error must be below `power`, or the test could not fail.
    """
    a, b = np.asarray(reference, np.float64), np.asarray(ours, np.float64)
    assert a.shape == b.shape
    assert np.isfinite(a).all()
    assert np.isfinite(b).all()
    whole_a, whole_b = a.mean(axis=(1, 2)), b.mean(axis=(1, 2))
    overall = max(float(whole_a.mean()), 1e-6)
    p, error, scale = _excess(whole_a, whole_b, tolerance, 0.05 * overall)
    assert (error <= power * scale).all(), f"standard error {error / scale} of the mean"
    seen = f"means {whole_a.mean(axis=0)} and {whole_b.mean(axis=0)} +- {error}"
    assert p.min() > sidak(p.size), f"{seen}, p = {p.min():.2g}"
    n, height, width = a.shape[:3]
    assert height % block == width % block == 0
    shape = (n, height // block, block, width // block, block, -1)
    blocks = [x.reshape(shape).mean(axis=(2, 4, 5)).reshape(n, -1) for x in (a, b)]
    p, error, scale = _excess(blocks[0], blocks[1], block_tolerance, overall)
    worst = int(p.argmin())
    assert p[worst] > sidak(p.size), (
        f"block {worst} of {width // block} a row: {blocks[0].mean(axis=0)[worst]:.5g} and "
        f"{blocks[1].mean(axis=0)[worst]:.5g} +- {error[worst]:.2g}, p = {p[worst]:.2g}; {seen}"
    )
