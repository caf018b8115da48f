"""Rebuilds the scenes: all of them, or those named."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from pathlib import Path

SCENES = (
    "cornell_box",
    "veach_plates",
    "door_ajar",
    "caustics",
    "pool",
    "exterior",
    "many_lights",
    "forest",
    "furnace",
    "half_mirror",
    "lamp_interior",
    "textured_room",
)
FOLDER = Path(__file__).resolve().parent.parent


def main(arguments: list[str]) -> int:
    """Builds the scenes named in `arguments` (none: all) and prints each file's size."""
    parser = argparse.ArgumentParser(prog="blend_scenes.authoring", description=__doc__)
    parser.add_argument("scenes", nargs="*", metavar="NAME", help=", ".join(SCENES))
    parser.add_argument("--folder", type=Path, default=FOLDER, help="where to save the files")
    options = parser.parse_args(arguments)
    unknown = set(options.scenes) - set(SCENES)
    if unknown:
        parser.error(f"no such scene: {', '.join(sorted(unknown))}")
    for name in options.scenes or SCENES:
        path = options.folder.resolve() / f"{name}.blend"
        importlib.import_module(f"{__package__}.{name}").build(path)
        print(f"{path.name}: {path.stat().st_size / 1024:.0f} KiB")
    return 0


def run() -> None:
    """Runs `main` and leaves at once: Blender 4.5 as a module hangs in its static destructors."""
    status = main(sys.argv[1:])
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)
