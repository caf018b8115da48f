"""What tests do in Blender's window, and how they know that it has happened."""

from __future__ import annotations

import time

import numpy as np

from .conftest import redness
from .session import BlenderSession

RENDERED = 'area("VIEW_3D").spaces[0].shading.type = "RENDERED"'
SOLID = 'area("VIEW_3D").spaces[0].shading.type = "SOLID"'
SHADER = 'bpy.data.objects["Cube"].active_material.node_tree.nodes["Principled BSDF"]'


def paint(blender: BlenderSession, color: str) -> None:
    blender.run(f'{SHADER}.inputs["Base Color"].default_value = {color}')


def is_rendering(blender: BlenderSession) -> bool:
    return bool(blender.run('result = bpy.app.is_job_running("RENDER")'))


def wait_for_render(blender: BlenderSession, timeout: float = 300.0) -> None:
    blender.wait_until(lambda: not is_rendering(blender), timeout, "the render's end")


def wait_for_red(
    blender: BlenderSession, name: str, region: tuple[slice, slice], least: float = 0.01
) -> np.ndarray:
    """A screenshot of a region, as soon as enough of it is red."""
    deadline = time.monotonic() + 30.0
    while True:
        pixels = blender.picture(name)[region]
        if redness(pixels) >= least:
            return pixels
        assert time.monotonic() < deadline, f"{name}: not red in 30 s\n{blender.log()}"


def start_render(blender: BlenderSession, key: str) -> None:
    blender.move(400, 400)
    blender.key(key)
    blender.wait_until(lambda: is_rendering(blender), 30.0, "a render")
