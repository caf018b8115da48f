"""Lamps, by Cycles' conventions."""

from __future__ import annotations

import bpy
import numpy as np
from engine_core.description import Graph, Light, Visibility

from .report import Report


def read_light(
    item: bpy.types.Object, transform: np.ndarray, visibility: int, graph: Graph, report: Report
) -> Light | None:
    """Reads a lamp at `transform` (3, 4); None: it is a portal, which gives no light."""
    data = item.data
    cycles = getattr(data, "cycles", None)
    if data.type == "AREA" and cycles is not None and cycles.is_portal:
        report.warn(f'light "{item.name}": portals are not supported; it is left out')
        return None
    light = Light(
        name=item.name,
        kind=data.type,
        transform=transform,
        emission=_emission(data),
        normalize=bool(data.normalize),
        visibility=visibility | Visibility.SHADOW,
        cast_shadow=bool(data.use_shadow),
        use_mis=cycles is None or bool(cycles.use_multiple_importance_sampling),
        graph=graph,
    )
    if data.type in ("POINT", "SPOT"):
        light.radius = float(data.shadow_soft_size)
        light.soft_falloff = bool(data.use_soft_falloff)
    if data.type == "SPOT":
        light.spot_angle = float(data.spot_size)
        light.spot_blend = float(data.spot_blend)
    elif data.type == "SUN":
        light.sun_angle = float(data.angle)
    elif data.type == "AREA":
        square = data.shape in ("SQUARE", "DISK")
        light.shape = "ELLIPSE" if data.shape in ("DISK", "ELLIPSE") else "RECTANGLE"
        light.size_x = float(data.size)
        light.size_y = float(data.size if square else data.size_y)
        light.spread = float(data.spread)
    return light


def _emission(data: bpy.types.Light) -> tuple[float, float, float]:
    """Colour times watts (sun: W/m^2), with exposure in stops and the blackbody's tint."""
    power = float(data.energy) * 2.0 ** float(data.exposure)
    color = np.array(data.color, np.float64)
    if data.use_temperature:
        color *= np.array(data.temperature_color, np.float64)[:3]
    red, green, blue = (color * power).tolist()
    return (red, green, blue)
