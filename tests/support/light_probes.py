"""Lights through the probes: receivers, samples by name, and what they are tested against."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from engine_core.description import Visibility
from numpy.typing import NDArray
from scenes import SceneBuilder
from statistics_tools import assert_chi_squared

import engine_core
from engine_core import probe

Array = NDArray[np.float64]
Vector = Sequence[float]

#: Rays that scattered: those that meet lamps with Blender's multiple importance sampling.
SCATTERED = int(Visibility.DIFFUSE)


class Samples:
    """Columns of probe.sample_lights by name, in float64."""

    def __init__(self, table: NDArray[np.float32]) -> None:
        t = np.asarray(table, np.float64)
        self.valid = t[:, 0] > 0
        self.wi, self.distance, self.radiance = t[:, 1:4], t[:, 4], t[:, 5:8]
        self.pdf, self.pdf_selection = t[:, 8], t[:, 9]
        self.p, self.n = t[:, 10:13], t[:, 13:16]
        self.light = t[:, 16].astype(np.uint32)
        self.delta, self.hittable = t[:, 17] > 0, t[:, 18] > 0


class Emissions:
    """Columns of probe.sample_emission by name, in float64."""

    def __init__(self, table: NDArray[np.float32]) -> None:
        t = np.asarray(table, np.float64)
        self.valid = t[:, 0] > 0
        self.p, self.direction, self.n = t[:, 1:4], t[:, 4:7], t[:, 7:10]
        self.cosine, self.radiance = t[:, 10], t[:, 11:14]
        self.pdf_position, self.pdf_direction = t[:, 14], t[:, 15]
        self.pdf_selection, self.lit_from = t[:, 16], t[:, 17]
        self.light = t[:, 18].astype(np.uint32)
        self.delta_position, self.delta_direction = t[:, 19] > 0, t[:, 20] > 0

    def flux(self) -> Array:
        """Watts of each sample over their number (first channel); the sum is the total power."""
        pdf = self.pdf_position * self.pdf_direction * self.pdf_selection
        weight = np.zeros(len(pdf))
        ok = self.valid
        weight[ok] = self.radiance[ok, 0] * self.cosine[ok] / pdf[ok]
        return weight / len(pdf)


def compiled(builder: SceneBuilder) -> Any:
    return engine_core.compile(builder.description, threads=1)


def unit(v: Vector | Array) -> Array:
    a = np.asarray(v, np.float64)
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def receiver(
    p: Vector, ng: Vector = (0, 0, 1), ns: Vector | None = None, transmits: bool = False
) -> NDArray[np.float32]:
    """One row of a receiver."""
    row = [*p, *unit(ng), *unit(ng if ns is None else ns), float(transmits)]
    return np.array([row], np.float32)


def uniforms(rng: np.random.Generator, n: int, columns: int) -> NDArray[np.float32]:
    """Canonical random numbers below 1 as a sampler makes them: 24 bits."""
    return (rng.integers(0, 1 << 24, (n, columns)) * 2.0**-24).astype(np.float32)


def sample(scene: Any, at: NDArray[np.float32], rng: np.random.Generator, n: int) -> Samples:
    return Samples(probe.sample_lights(scene, at, uniforms(rng, n, 3)))


def met(scene: Any, at: NDArray[np.float32], d: Array) -> tuple[Array, Array, Array]:
    """Number of lights that rays in these directions meet, their radiance (red) and density."""
    rows = np.ascontiguousarray(unit(d), np.float32)
    t = np.asarray(probe.meet_lights(scene, at, rows, SCATTERED), np.float64)
    return t[:, 0], t[:, 2], t[:, 5]


def frame(axis: Array) -> Array:
    """Rows of an orthonormal basis, the axis last."""
    helper = np.array([1.0, 0, 0]) if abs(axis[0]) < 0.7 else np.array([0.0, 1, 0])
    s = unit(np.cross(axis, helper))
    return np.stack([s, np.cross(axis, s), axis])


class ConeChart:
    """Cells of equal solid angle in the cone of 1 - cos = `height` about an axis."""

    def __init__(self, d: Array) -> None:
        self.axis = unit(d.mean(axis=0))
        spread = np.linalg.norm(d - self.axis, axis=1).max()
        self.height = min(0.5 * (spread * 1.02) ** 2, 2.0)  # |a - b|^2 = 2 (1 - cos)

    def direction(self, x: Array, y: Array) -> Array:
        """Of points of the unit square."""
        h, phi = x * self.height, 2 * np.pi * y
        r = np.sqrt(h * (2 - h))
        return np.stack([r * np.cos(phi), r * np.sin(phi), 1 - h], axis=-1) @ frame(self.axis)

    def solid_angle(self, d: Array) -> Array:
        """Per unit of area of the square."""
        return np.full(d.shape[:-1], 2 * np.pi * self.height)

    def point(self, d: Array) -> tuple[Array, Array]:
        local = d @ frame(self.axis).T
        # 1 - cos from the sine, which keeps its digits in narrow cones.
        z = local[:, 2]
        h = np.where(z > 0, (local[:, :2] ** 2).sum(axis=1) / (1 + np.maximum(z, 0)), 1 - z)
        phi = np.arctan2(local[:, 1], local[:, 0]) % (2 * np.pi)
        return h / self.height, phi / (2 * np.pi)


class PlaneChart:
    """A rectangle of the tangent plane along the directions' principal axes: for thin lights."""

    def __init__(self, d: Array) -> None:
        axis = unit(d.mean(axis=0))
        flat = d / (d @ axis)[:, None] - axis
        across = np.linalg.svd(flat - flat.mean(axis=0), full_matrices=False)[2][0]
        s = unit(across - axis * (across @ axis))
        self.basis = np.stack([s, np.cross(axis, s), axis])
        x, y = self._plane(d)
        margin = 0.01
        self.low = np.array([x.min(), y.min()])
        self.size = np.array([np.ptp(x), np.ptp(y)]) * (1 + 2 * margin)
        self.low -= self.size * margin / (1 + 2 * margin)

    def _plane(self, d: Array) -> tuple[Array, Array]:
        local = d @ self.basis.T
        return local[..., 0] / local[..., 2], local[..., 1] / local[..., 2]

    def direction(self, x: Array, y: Array) -> Array:
        p = np.stack([x, y], axis=-1) * self.size + self.low
        return unit(np.concatenate([p, np.ones((*p.shape[:-1], 1))], axis=-1) @ self.basis)

    def solid_angle(self, d: Array) -> Array:
        return (d @ self.basis[2]) ** 3 * self.size.prod()

    def point(self, d: Array) -> tuple[Array, Array]:
        x, y = self._plane(d)
        return (x - self.low[0]) / self.size[0], (y - self.low[1]) / self.size[1]


def assert_samples_follow_density(
    scene: Any,
    at: NDArray[np.float32],
    rng: np.random.Generator,
    n: int = 20_000,
    bins: int = 12,
    fine: int = 16,
    thin: bool = False,
) -> Samples:
    """Chi-squared of the sampled directions against the density of the rays that meet lights.

    Samples without a value are one more cell: the density's integral falls short of 1 by them.
    """
    s = sample(scene, at, rng, n)
    d = unit(s.wi[s.valid])
    chart = PlaneChart(d) if thin else ConeChart(d)
    grid = (np.arange(bins * fine) + 0.5) / (bins * fine)
    x, y = np.meshgrid(grid, grid, indexing="ij")
    directions = chart.direction(x, y)
    density = met(scene, at, directions.reshape(-1, 3))[2].reshape(x.shape)
    mass = density * chart.solid_angle(directions) / x.size
    expected = n * mass.reshape(bins, fine, bins, fine).sum(axis=(1, 3))
    px, py = chart.point(d)
    observed = np.histogram2d(px, py, bins=bins, range=[[0, 1], [0, 1]])[0]
    rest = n - expected.sum()
    # The cells' integrals are sums: their error, some parts in a thousand, may not fill the rest.
    assert rest > -0.01 * n, f"the density integrates to {expected.sum() / n:.4f}"
    lost = n - len(d)
    if lost > 0.01 * n or rest > 0.01 * n:
        assert_chi_squared(np.append(observed, lost), np.append(expected, rest))
    else:
        assert_chi_squared(observed, expected * len(d) / expected.sum())
    return s
