"""Color spaces of images."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from engine_core.description import FloatArray
from numpy.typing import NDArray

# Names that Blender's configuration has for the two encodings which the core decodes itself.
SRGB = {"sRGB", "sRGB OETF", "sRGB EOTF"}
LINEAR = {"Linear Rec.709", "Linear", "Non-Color", "Raw", "scene_linear"}


def to_scene_linear(pixels: NDArray[Any], space: str) -> FloatArray | None:
    """Converts bytes or floats by Blender's OpenColorIO configuration; None: it cannot be done."""
    processor = _processor(space)
    if processor is None:
        return None
    values = pixels.astype(np.float32) / np.float32(255.0 if pixels.dtype == np.uint8 else 1.0)
    rgb = values[:, :, :3] if values.shape[2] >= 3 else np.repeat(values, 3, axis=2)
    rgb = np.ascontiguousarray(rgb)
    processor.applyRGB(rgb)
    if values.shape[2] == 4:
        return np.concatenate((rgb, values[:, :, 3:]), axis=2)
    return rgb


@cache
def _processor(space: str) -> Any:
    """OpenColorIO's CPU processor from `space` to scene linear; None: not to be had."""
    _find_blenders_modules()
    try:
        import PyOpenColorIO
    except ImportError:
        return None
    folder = bpy.utils.system_resource("DATAFILES", path="colormanagement")
    path = Path(folder) / "config.ocio"
    if not path.is_file():
        return None
    try:
        config = PyOpenColorIO.Config.CreateFromFile(str(path))
        return config.getProcessor(space, "scene_linear").getDefaultCPUProcessor()
    except PyOpenColorIO.Exception:
        return None


def _find_blenders_modules() -> None:
    """Blender as a module carries PyOpenColorIO in a folder of its own, off the path."""
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    python = bpy.utils.system_resource("PYTHON", path=f"lib/{version}/site-packages")
    if python and python not in sys.path:
        sys.path.append(python)


def srgb_to_linear(values: FloatArray) -> FloatArray:
    """IEC 61966-2-1, for any shape."""
    low = values / 12.92
    high = ((np.maximum(values, 0.04045) + 0.055) / 1.055) ** 2.4
    return np.where(values <= 0.04045, low, high).astype(np.float32)
