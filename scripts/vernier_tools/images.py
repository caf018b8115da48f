"""Pictures as numpy arrays: reading, writing and the colours that show a difference."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO
from numpy.typing import NDArray

from vernier_tools.errors import ToolError

FloatImage = NDArray[np.float32]  # (height, width, channels), top row first

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)  # of linear Rec.709 primaries


def read_combined(path: Path) -> FloatImage:
    """The colours of a picture: (h, w, 3). Of a multilayer EXR the compositor's picture where there
    is one, or the Combined pass."""
    source = OpenImageIO.ImageInput.open(str(path))
    if source is None:
        raise ToolError(f"{path}: {OpenImageIO.geterror()}")
    try:
        names = list(source.spec().channelnames)
        pixels = source.read_image(OpenImageIO.FLOAT)
    finally:
        source.close()
    if pixels is None:
        raise ToolError(f"{path}: cannot be read")
    combined = [i for i, name in enumerate(names) if name.split(".")[-2:-1] == ["Combined"]]
    composite = [i for i in combined if names[i].startswith("Composite.")]
    first = (composite or combined)[:3] or [0, 1, 2]
    return np.ascontiguousarray(pixels[:, :, first], np.float32)


def write_png(path: Path, image: FloatImage) -> None:
    """Writes values in [0, 1] (already encoded for display) as an 8-bit PNG, clipping others."""
    pixels = np.clip(np.nan_to_num(image) * 255 + 0.5, 0, 255).astype(np.uint8)
    height, width, channels = pixels.shape
    output = OpenImageIO.ImageOutput.create(str(path))
    if output is None:
        raise ToolError(f"{path}: {OpenImageIO.geterror()}")
    try:
        if not output.open(
            str(path), OpenImageIO.ImageSpec(width, height, channels, OpenImageIO.UINT8)
        ):
            raise ToolError(f"{path}: {output.geterror()}")
        output.write_image(np.ascontiguousarray(pixels))
    finally:
        output.close()


def luminance(image: FloatImage) -> FloatImage:
    """(h, w) luminance of linear colours (h, w, 3)."""
    return np.asarray(image @ LUMINANCE, np.float32)


def diverging(values: FloatImage, scale: float) -> FloatImage:
    """(h, w) values as colours: blue at -scale, white at 0, red at +scale; clipped beyond."""
    t = np.clip(values / scale, -1, 1)[:, :, None]
    blue, red = np.array([0.13, 0.27, 0.6]), np.array([0.7, 0.0, 0.1])
    return np.asarray(np.where(t < 0, 1 + (blue - 1) * -t, 1 + (red - 1) * t), np.float32)


def heat(values: FloatImage) -> FloatImage:
    """(h, w) values in [0, 1] as colours from black over violet and orange to pale yellow."""
    stops = np.array([0.0, 0.3, 0.6, 0.85, 1.0])
    colors = np.array(
        [[0, 0, 0.02], [0.34, 0.06, 0.43], [0.87, 0.32, 0.23], [0.99, 0.75, 0.3], [0.99, 1, 0.75]]
    )
    t = np.clip(values, 0, 1)
    return np.stack([np.interp(t, stops, colors[:, c]) for c in range(3)], axis=2).astype(
        np.float32
    )


def block_sums(image: FloatImage, size: int) -> NDArray[np.float64]:
    """(h, w) summed over blocks of `size` pixels; an incomplete last row or column is left out."""
    rows, columns = image.shape[0] // size, image.shape[1] // size
    cut = image[: rows * size, : columns * size].astype(np.float64)
    return np.asarray(cut.reshape(rows, size, columns, size).sum(axis=(1, 3)))


def enlarge(image: FloatImage, size: int) -> FloatImage:
    """Every pixel as a block of `size` by `size`."""
    return np.asarray(np.repeat(np.repeat(image, size, axis=0), size, axis=1))
