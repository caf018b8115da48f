"""Small node graphs and the points to evaluate them at."""

from __future__ import annotations

import numpy as np
from engine_core.description import Graph, Link, Node
from numpy.typing import NDArray

from engine_core import probe

FloatArray = NDArray[np.float32]


def points(count: int, low: float = -2.0, high: float = 2.0) -> tuple[FloatArray, ...]:
    """Random positions, normals and directions to the viewer on the normals' side."""
    rng = np.random.default_rng(7)
    p = rng.uniform(low, high, (count, 3)).astype(np.float32)
    n, wo = (rng.normal(size=(2, count, 3))).astype(np.float32)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    wo *= np.where((n * wo).sum(axis=1) < 0, -1, 1)[:, None]
    return p, n, np.ascontiguousarray(wo, np.float32)


def value_of(nodes: list[Node], output: str, count: int = 1) -> FloatArray:
    """The last node's output at random points, (count, 3)."""
    material = probe.compile_graph(Graph(nodes, Link(len(nodes) - 1, output)))
    values: FloatArray = material.emission(*points(count))
    return values


def emission_of(nodes: list[Node], surface: Link) -> tuple[float, ...]:
    """The value of a graph that is the same everywhere."""
    return tuple(probe.compile_graph(Graph(nodes, surface)).emission(*points(1))[0].tolist())
