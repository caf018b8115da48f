"""Writes the finished render to a picture file, whole or not at all."""

from __future__ import annotations

import os
import re
import signal
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import bpy

from vernier_tools.errors import ToolError


@dataclass(frozen=True)
class Format:
    """How Blender names a file format: `depth` is bits per channel, "" where there is no choice."""

    identifier: str
    depth: str
    alpha: bool


FORMATS = {
    ".exr": Format("OPEN_EXR_MULTILAYER", "32", True),
    ".png": Format("PNG", "8", True),
    ".tif": Format("TIFF", "16", True),
    ".tiff": Format("TIFF", "16", True),
    ".jpg": Format("JPEG", "", False),
    ".jpeg": Format("JPEG", "", False),
}


def check_output(path: Path) -> None:
    """Raises ToolError when no picture could be written to `path`, before time is spent on one."""
    if path.suffix.lower() not in FORMATS:
        known = ", ".join(FORMATS)
        raise ToolError(f"{path}: the name must end in one of {known}")
    folder = path.parent
    if not folder.is_dir():
        raise ToolError(f"{path}: the folder {folder} does not exist")
    if path.is_dir():
        raise ToolError(f"{path}: is a folder")
    if not os.access(folder, os.W_OK):
        raise ToolError(f"{path}: the folder {folder} cannot be written to")


def frame_path(pattern: Path, frame: int) -> Path:
    """`pattern` with its last run of `#` in the file's name replaced by the frame's number.

    The number is padded with zeros to the run's length. Without `#`, `_####` goes before the
    suffix.
    """
    runs = list(re.finditer("#+", pattern.name))
    if not runs:
        return pattern.with_name(f"{pattern.stem}_{frame:04d}{pattern.suffix}")
    start, end = runs[-1].span()
    number = str(frame).zfill(end - start)
    return pattern.with_name(pattern.name[:start] + number + pattern.name[end:])


def save_render(scene: bpy.types.Scene, path: Path) -> None:
    """Saves the render result: multilayer EXR linear with all passes, others as they are viewed.

    The file is written beside `path` under a temporary name, then renamed over it. Raises
    ToolError.
    """
    kind = FORMATS[path.suffix.lower()]
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # Blender 5: the formats to choose from depend on it.
        multilayer = kind.identifier == "OPEN_EXR_MULTILAYER"
        settings.media_type = "MULTI_LAYER_IMAGE" if multilayer else "IMAGE"
    settings.file_format = kind.identifier
    if kind.depth:
        settings.color_depth = kind.depth
    settings.color_mode = "RGBA" if kind.alpha and scene.render.film_transparent else "RGB"
    settings.color_management = "FOLLOW_SCENE"
    if kind.identifier == "OPEN_EXR_MULTILAYER":
        settings.color_mode = "RGBA"
        settings.exr_codec = "ZIP"
    elif kind.identifier == "JPEG":
        settings.quality = 95
    with uninterrupted():
        save_whole(scene, path)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Holds back an interruption until the block is done, so that no temporary file stays."""
    signals = {signal.SIGINT, signal.SIGTERM}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def save_whole(scene: bpy.types.Scene, path: Path) -> None:
    handle, name = tempfile.mkstemp(path.suffix, f".{path.stem}-", path.parent)
    os.close(handle)
    try:
        bpy.data.images["Render Result"].save_render(name, scene=scene)
        if os.path.getsize(name) == 0:
            raise ToolError(f"{path}: Blender wrote an empty file")
        os.chmod(name, 0o666 & ~current_umask())
        os.replace(name, path)
    except (OSError, RuntimeError) as error:
        raise ToolError(f"{path}: cannot be written: {error}") from error
    finally:
        Path(name).unlink(missing_ok=True)


def current_umask() -> int:
    """The mask that ordinary files are made with; temporary ones are private regardless of it."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
