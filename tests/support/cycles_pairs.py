"""One scene rendered by Cycles and by Vernier with equal settings, in a process of its own.

The programs that use it (`material_sheet.py`, `light_pairs.py`, `pass_pairs.py`) write an .npz file
with the pictures of both engines, (seeds, height, width, channels), top row first.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]
ENGINES = ("CYCLES", "VERNIER")


def start() -> Any:
    """Blender with an empty scene and both engines; returns `bpy`."""
    sys.path.insert(0, str(Path(__file__).parents[2]))
    import bpy

    import addon

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    addon.register()
    return bpy


def finish(path: str, arrays: dict[str, Array]) -> None:
    """Writes the arrays and ends the process: Blender 4.5 as a module hangs when it exits."""
    np.savez(path, allow_pickle=False, **arrays)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


def set_up(scene: Any, width: int, height: int, samples: int) -> None:
    """Equal settings for both: no clamp, no filter of glossy rays, one box filter, 32 bounces."""
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.threads_mode, render.threads = "FIXED", 2
    render.use_compositing = render.use_sequencer = False
    cycles, vernier = scene.cycles, scene.vernier
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = cycles.light_sampling_threshold = 0.0
    cycles.pixel_filter_type = vernier.pixel_filter = "BOX"
    vernier.filter_width = 1.0
    cycles.samples = vernier.samples = samples
    kinds = ("max_", "diffuse_", "glossy_", "transmission_")
    for name in (f"{kind}bounces" for kind in kinds):
        setattr(cycles, name, 32)
        setattr(vernier, name, 32)
    cycles.transparent_max_bounces = vernier.transparent_bounces = 32


def render(scene: Any, seeds: int, channels: int = 3) -> dict[str, Array]:
    """The combined pictures of both engines, (seeds, height, width, channels)."""
    import bpy

    result: dict[str, Array] = {}
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "picture.exr")
        for engine in ENGINES:
            scene.render.engine = engine
            pictures = []
            for seed in range(1, seeds + 1):
                scene.cycles.seed = scene.vernier.seed = seed
                bpy.ops.render.render(write_still=True)
                image = bpy.data.images.load(scene.render.filepath)
                pixels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
                image.pixels.foreach_get(pixels)
                shape = (image.size[1], image.size[0], 4)
                bpy.data.images.remove(image)
                pictures.append(pixels.reshape(shape)[::-1, :, :channels])
            result[engine] = np.stack(pictures)
    return result


def run(program: str, path: Path, *arguments: str) -> dict[str, Array]:
    """Runs a program of this folder and returns the arrays that it wrote to `path`."""
    script = Path(__file__).with_name(program)
    done = subprocess.run(
        [sys.executable, str(script), str(path), *arguments],
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    if done.returncode or not path.exists():
        raise RuntimeError(f"{program} failed:\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}")
    with np.load(path) as archive:
        return dict(archive)
