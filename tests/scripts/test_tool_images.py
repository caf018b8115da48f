"""Reading, writing and colouring pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from vernier_tools import images
from vernier_tools.errors import ToolError


def test_png_round_trip_clips_and_rounds(tmp_path: Path) -> None:
    image = np.array([[[0.0, 0.5, 1.0], [-1.0, 2.0, 0.2]]], np.float32)
    images.write_png(tmp_path / "a.png", image)
    back = images.read_combined(tmp_path / "a.png")
    assert back.shape == (1, 2, 3)
    np.testing.assert_allclose(back, np.clip(image, 0, 1), atol=0.5 / 255 + 1e-6)


def test_the_combined_pass_is_found_among_others(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    names = [f"Layer.{n}" for n in ("Depth.Z", "Combined.R", "Combined.G", "Combined.B")]
    spec = OpenImageIO.ImageSpec(2, 1, 4, OpenImageIO.FLOAT)
    spec.channelnames = names
    output = OpenImageIO.ImageOutput.create(str(path))
    assert output is not None
    assert output.open(str(path), spec)
    output.write_image(np.arange(8, dtype=np.float32).reshape(1, 2, 4))
    output.close()
    np.testing.assert_array_equal(images.read_combined(path), [[[1, 2, 3], [5, 6, 7]]])


def test_an_unreadable_picture_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.exr").write_text("no picture")
    with pytest.raises(ToolError, match=r"a\.exr"):
        images.read_combined(tmp_path / "a.exr")


def test_diverging_colours_tell_the_sign() -> None:
    colors = images.diverging(np.array([[-9.0, -1.0, 0.0, 1.0, 9.0]], np.float32), 1.0)[0]
    np.testing.assert_array_equal(colors[2], [1, 1, 1])
    np.testing.assert_array_equal(colors[0], colors[1])
    np.testing.assert_array_equal(colors[3], colors[4])
    assert colors[0][2] > colors[0][0]
    assert colors[4][0] > colors[4][2]


def test_heat_grows_brighter() -> None:
    shades = images.luminance(images.heat(np.linspace(0, 1, 50, dtype=np.float32)[None]))[0]
    assert np.all(np.diff(shades) > 0)


def test_block_sums_leave_out_what_is_no_whole_block() -> None:
    image = np.arange(20, dtype=np.float32).reshape(4, 5)
    np.testing.assert_array_equal(images.block_sums(image, 2), [[12, 20], [52, 60]])
    assert images.enlarge(image[:1, :1], 3).shape == (3, 3)
