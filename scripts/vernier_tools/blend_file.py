"""Opens .blend files in bpy and says plainly what is wrong with one that cannot be rendered."""

from __future__ import annotations

from pathlib import Path

import bpy

from vernier_tools.errors import ToolError

# How a .blend file begins: as it is, or compressed by Zstandard or (older ones) by gzip.
SIGNATURES = (b"BLENDER", b"\x28\xb5\x2f\xfd", b"\x1f\x8b")


def open_blend(path: Path) -> bpy.types.Scene:
    """Opens the file and returns its active scene. Scripts inside the file are not run.

    Raises ToolError when the file is missing, is no .blend file or cannot be read.
    """
    try:
        with open(path, "rb") as file:
            start = file.read(8)
    except OSError as error:
        raise ToolError(f"{path}: {error.strerror}") from error
    if not start.startswith(SIGNATURES):
        raise ToolError(f"{path}: not a .blend file")
    # bpy raises RuntimeError for mere warnings too (a missing library, say): what tells is whether
    # the file is open afterwards.
    message = ""
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=False)
    except RuntimeError as error:
        message = str(error).strip().removeprefix("Error: ")
    if not bpy.data.filepath:
        raise ToolError(f"{path}: the file is damaged, or newer than this Blender: {message}")
    return bpy.context.scene


def require_camera(scene: bpy.types.Scene) -> None:
    """Raises ToolError when the scene has nothing to be seen through."""
    if scene.camera is None:
        raise ToolError(f'the scene "{scene.name}" has no camera')
