"""Nodes that read the surface, through Blender and both engines, pixel by pixel."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import surface_values
from emitted_values import decoded
from numpy.typing import NDArray
from surface_values import CASES, COLUMNS, TILE

FloatArray = NDArray[np.float32]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> dict[str, FloatArray]:
    pytest.importorskip("bpy")
    result = tmp_path_factory.mktemp("surface") / "pictures.npz"
    program = Path(surface_values.__file__)
    subprocess.run([sys.executable, str(program), str(result)], check=True, timeout=300)
    return dict(np.load(result))


def tile(picture: FloatArray, number: int) -> FloatArray:
    """A case's part of a picture, (TILE, TILE, 3)."""
    x, y = number % COLUMNS * TILE, number // COLUMNS * TILE
    return picture[y : y + TILE, x : x + TILE]


def inside(mask: NDArray[np.bool_], by: int) -> NDArray[np.bool_]:
    """Pixels whose neighbours up to `by` away are in the mask too."""
    for _ in range(by):
        padded = np.pad(mask, 1)
        mask = (
            padded[1:-1, 1:-1]
            & padded[:-2, 1:-1]
            & padded[2:, 1:-1]
            & padded[1:-1, :-2]
            & padded[1:-1, 2:]
        )
    return mask


@pytest.mark.parametrize("number", range(len(CASES)), ids=[case[0] for case in CASES])
def test_node_agrees_with_cycles_on_a_sphere(number: int, pictures: dict[str, FloatArray]) -> None:
    theirs, ours = tile(pictures["CYCLES"], number), tile(pictures["VERNIER"], number)
    # The rim is left out: there a hundredth of a pixel is much of the sphere.
    sphere = inside(theirs.max(axis=2) > 0, 3)
    assert sphere.sum() > 300
    theirs, ours = decoded(theirs[sphere]), decoded(ours[sphere])
    error = np.abs(ours - theirs).max(axis=1) / max(1.0, float(np.abs(theirs).max()))
    # The pixel's jitter of a hundredth, times slopes up to one in a few pixels. Steps of closest
    # interpolation may fall on the other side in few pixels.
    assert np.median(error) < 0.004
    assert np.quantile(error, 0.9) < 0.02
