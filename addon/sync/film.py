"""The picture: size, border, transparency."""

from __future__ import annotations

import bpy
from engine_core.description import Film

from .camera import Frame


def read_film(
    scene: bpy.types.Scene, layer: bpy.types.ViewLayer, frame: Frame, border: bool = True
) -> Film:
    """Reads what Blender itself knows; `border` False renders the whole frame whatever it is.

    The filter and the exposure are the engine's own settings (`SyncOptions`).
    """
    render = scene.render
    crop = (0, 0, frame.width, frame.height)
    if border and render.use_border:
        crop = border_rectangle(render, frame)
    return Film(
        width=frame.width,
        height=frame.height,
        crop=crop,
        transparent=bool(render.film_transparent),
        pass_alpha_threshold=float(layer.pass_alpha_threshold),
    )


def border_rectangle(render: bpy.types.RenderSettings, frame: Frame) -> tuple[int, int, int, int]:
    """x0, y0, x1, y1 of the border, rounded down as Blender's render pipeline does; y upward."""
    x0 = min(int(render.border_min_x * frame.width), frame.width - 1)
    y0 = min(int(render.border_min_y * frame.height), frame.height - 1)
    x1 = max(int(render.border_max_x * frame.width), x0 + 1)
    y1 = max(int(render.border_max_y * frame.height), y0 + 1)
    return (x0, y0, min(x1, frame.width), min(y1, frame.height))
