"""Images: pixels as Blender holds them, as bytes where the file has bytes."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from engine_core.description import FloatArray, Image
from numpy.typing import NDArray

from . import colorspace
from .id_map import IdMap
from .report import Report

Pixels = NDArray[np.uint8] | FloatArray


class ImageTable:
    """The images of one description; what did not change since the last one is kept."""

    def __init__(self, cache: IdMap[Image], frame: int, report: Report) -> None:
        self._cache = cache
        self._frame = frame
        self._report = report
        self._indices: dict[tuple[int, int], int] = {}
        self.images: list[Image] = []

    def index(self, image: bpy.types.Image, user: bpy.types.ImageUser) -> int:
        """The image's index; read now if it is new."""
        frame = sequence_frame(image, user, self._frame)
        key = (image.original.session_uid, frame)
        if key not in self._indices:
            self._indices[key] = len(self.images)
            make = lambda: read_image(image, frame, self._report)  # noqa: E731
            # The number of a frame is text: keys of numbers are session identifiers.
            self.images.append(self._cache.get((key[0], str(frame)), make))
        return self._indices[key]


def sequence_frame(image: bpy.types.Image, user: bpy.types.ImageUser, frame: int) -> int:
    """The number of the sequence's file at a scene frame; 0 for what is no sequence."""
    if image.source != "SEQUENCE":
        return 0
    number = frame - user.frame_start + 1
    length = max(1, user.frame_duration)
    number = (number - 1) % length + 1 if user.use_cyclic else min(max(number, 1), length)
    return int(number + user.frame_offset)


def read_image(image: bpy.types.Image, frame: int, report: Report) -> Image:
    """Reads an image; `frame` is the file's number in a sequence."""
    name = f'image "{image.name}"'
    if image.source in ("TILED", "MOVIE"):
        what = "tiles (UDIM)" if image.source == "TILED" else "movies"
        report.warn(f"{name}: {what} are not supported; the first one's picture is used everywhere")
    pixels = _read_sequence(image, frame, report) if frame else _read_buffer(image)
    result = Image(name=image.name, pixels=pixels, alpha=_alpha(image, pixels))
    if pixels is None:
        path = image.filepath or "no file"
        report.warn(f"{name}: cannot be read ({path}); it is drawn magenta")
        return result
    if pixels.dtype == np.uint8:
        _decode_bytes(image, result, report)
    else:
        result.encoding = "linear"
        if not np.isfinite(pixels).all():
            report.warn(f"{name}: holds pixels that are not finite; they are read as 0")
            result.pixels = np.nan_to_num(pixels, nan=0.0, posinf=0.0, neginf=0.0)
    return result


def _read_buffer(image: bpy.types.Image) -> Pixels | None:
    """The pixels in Blender's memory, (height, width, channels), bottom row first."""
    width, height = image.size  # makes Blender load the file
    channels = image.channels
    if not (width and height and channels and len(image.pixels) == width * height * channels):
        return None
    pixels = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(pixels)
    if not image.is_float:
        pixels *= 255.0
        pixels += 0.5
        pixels = pixels.astype(np.uint8)
    return _without_spare_channels(pixels.reshape(height, width, channels))


def _without_spare_channels(pixels: NDArray[Any]) -> NDArray[Any]:
    """Drops an alpha of 1 everywhere, which Blender adds to files that have none."""
    if pixels.shape[2] == 2:  # grey and alpha
        pixels = pixels[:, :, (0, 0, 0, 1)]
    opaque: float = 255 if pixels.dtype == np.uint8 else 1.0
    if pixels.shape[2] == 4 and (pixels[:, :, 3] == opaque).all():
        pixels = pixels[:, :, :3]
    return np.ascontiguousarray(pixels)


def _alpha(image: bpy.types.Image, pixels: Pixels | None) -> str:
    """How color and alpha relate in Blender's buffers: bytes straight, floats premultiplied."""
    if image.alpha_mode in ("CHANNEL_PACKED", "NONE"):
        return str(image.alpha_mode)
    if image.colorspace_settings.is_data:
        return "CHANNEL_PACKED"
    return "PREMUL" if pixels is not None and pixels.dtype != np.uint8 else "STRAIGHT"


def _decode_bytes(image: bpy.types.Image, result: Image, report: Report) -> None:
    """States the bytes' encoding, or converts them where it is neither sRGB nor linear."""
    space = image.colorspace_settings.name
    if image.colorspace_settings.is_data or space in colorspace.LINEAR:
        result.encoding = "linear"
        return
    result.encoding = "srgb"
    if space in colorspace.SRGB:
        return
    assert result.pixels is not None
    converted = colorspace.to_scene_linear(result.pixels, space)
    if converted is None:
        _warn_of_space(image, "sRGB", report)
        return
    result.pixels, result.encoding = converted, "linear"


def _read_sequence(image: bpy.types.Image, frame: int, report: Report) -> Pixels | None:
    """Reads one file of a sequence; Blender's Python shows only one frame of it."""
    path = _sequence_path(image, frame)
    try:
        import OpenImageIO
    except ImportError:
        report.warn(f'image "{image.name}": no module to read sequences; its first frame is used')
        return _read_buffer(image)
    source = OpenImageIO.ImageBuf(str(path))
    eight_bit = source.spec().format == OpenImageIO.UINT8
    data = None
    if source.spec().width and not source.has_error:
        data = source.get_pixels(OpenImageIO.UINT8 if eight_bit else OpenImageIO.FLOAT)
    damage = " ".join(source.geterror().split())
    if data is None:
        return None
    if damage:
        report.warn(f'image "{image.name}": {path.name} is damaged, and read in part ({damage})')
    pixels = np.ascontiguousarray(data[::-1])
    if not eight_bit:
        pixels = _linear_floats(image, pixels, report)
    return _without_spare_channels(pixels)


def _linear_floats(image: bpy.types.Image, pixels: FloatArray, report: Report) -> FloatArray:
    """A file's floats as Blender holds them: scene linear, whatever the image's color space."""
    space = image.colorspace_settings.name
    if image.colorspace_settings.is_data or space in colorspace.LINEAR:
        return pixels
    if space in colorspace.SRGB:
        pixels[:, :, :3] = colorspace.srgb_to_linear(pixels[:, :, :3])
        return pixels
    converted = colorspace.to_scene_linear(pixels, space)
    if converted is None:
        _warn_of_space(image, "linear", report)
        return pixels
    return converted


def _warn_of_space(image: bpy.types.Image, instead: str, report: Report) -> None:
    report.warn(
        f'image "{image.name}": the color space "{image.colorspace_settings.name}" cannot be '
        f"converted; it is read as {instead}"
    )


def _sequence_path(image: bpy.types.Image, frame: int) -> Path:
    """The file's path with the last run of digits replaced by the frame's number."""
    path = Path(bpy.path.abspath(image.filepath, library=image.library))
    digits = re.search(r"(\d+)(\D*)$", path.stem)
    if digits is None:
        return path
    number = str(frame).zfill(len(digits.group(1)))
    return path.with_name(path.stem[: digits.start()] + number + digits.group(2) + path.suffix)
