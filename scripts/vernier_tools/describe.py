"""Descriptions of .blend files for tools that render by the core alone.

Usage of the process that makes one: python -m vernier_tools.describe SCENE.blend OUT
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vernier_tools.errors import ToolError

if TYPE_CHECKING:
    from engine_core.description import SceneDescription


def described(scene: Path) -> SceneDescription:
    """The file's scene. Raises ToolError."""
    from engine_core import storage

    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder, "scene.vernier")
        # Blender is not left in this process: its memory and threads are not to be measured.
        command = [sys.executable, "-m", "vernier_tools.describe", str(scene), str(target)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            lines = [line for line in done.stderr.splitlines() if line.strip()]
            raise ToolError(lines[-1] if lines else f"{scene}: Blender ended without a word")
        return storage.load(target)


def sized(description: SceneDescription, width: int) -> SceneDescription:
    """The whole frame, `width` pixels wide; changes the description."""
    film = description.film
    film.height = max(round(width * film.height / film.width), 1)
    film.width = width
    film.crop = (0, 0, film.width, film.height)
    return description


def write(scene: Path, target: Path) -> None:
    """Raises ToolError."""
    import bpy

    from engine_core import storage
    from vernier_tools import engines
    from vernier_tools.blend_file import open_blend, require_camera

    # What a file says of the film is in Cycles' properties.
    engines.enable_cycles()
    require_camera(open_blend(scene))
    engines.register_vernier()
    from addon.export import export_scene

    description: Any
    description, _ = export_scene(bpy.context.evaluated_depsgraph_get(), border=False)
    storage.save(description, target)


def main() -> None:
    code = 0
    try:
        write(Path(sys.argv[1]), Path(sys.argv[2]))
    except (ToolError, OSError, ValueError) as error:
        print(" ".join(str(error).split()), file=sys.stderr, flush=True)
        code = 1
    # Blender 4.5 hangs when its interpreter shuts down.
    os._exit(code)


if __name__ == "__main__":
    main()
