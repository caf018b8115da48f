"""Node properties that are no plain values, each with the form the scene description gives it."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
from engine_core.description import ParamValue

# Number of samples of a curve; what Cycles and Blender's own look-up tables use.
CURVE_SAMPLES = 256

# Properties of single kinds of node that say nothing about the picture.
IGNORED = {"texture_mapping", "color_mapping", "image_user", "node_tree", "script", "show_texture"}


def color_ramp(ramp: bpy.types.ColorRamp) -> dict[str, ParamValue]:
    """Rows (position, r, g, b, a) in order of position, and how to go between them."""
    rows = sorted((e.position, *e.color) for e in ramp.elements)
    table = np.array(rows, np.float32).reshape(-1)
    result: dict[str, ParamValue] = {"ramp": table, "color_mode": ramp.color_mode}
    result["interpolation"] = ramp.interpolation
    result["hue_interpolation"] = ramp.hue_interpolation
    return result


def curve_mapping(mapping: bpy.types.CurveMapping) -> dict[str, ParamValue]:
    """Curves as tables over [min_x, max_x]: `curves` has CURVE_SAMPLES rows of one value per curve.

    A fourth curve (RGB: the combined one, applied first) is folded into the others, as in Cycles.
    """
    mapping.initialize()
    curves = list(mapping.curves)
    low, high = _curve_range(mapping, curves)
    positions = np.linspace(low, high, CURVE_SAMPLES)
    evaluate = mapping.evaluate
    columns: list[list[float]]
    if len(curves) == 4:
        combined = [evaluate(curves[3], x) for x in positions]
        columns = [[evaluate(curve, x) for x in combined] for curve in curves[:3]]
    else:
        columns = [[evaluate(curve, x) for x in positions] for curve in curves]
    table = np.array(columns, np.float32).T
    return {
        "curves": np.ascontiguousarray(table).reshape(-1),
        "min_x": low,
        "max_x": high,
        "extrapolate": mapping.extend == "EXTRAPOLATED",
    }


def _curve_range(
    mapping: bpy.types.CurveMapping, curves: list[bpy.types.CurveMap]
) -> tuple[float, float]:
    """The interval on which the curves are defined: the points', widened to the clip box's."""
    xs = [point.location[0] for curve in curves for point in curve.points]
    low, high = min(xs), max(xs)
    if mapping.use_clip:
        low, high = min(low, mapping.clip_min_x), max(high, mapping.clip_max_x)
    return (low, high) if high > low else (low, low + 1.0)


def output_direction(node: bpy.types.Node) -> dict[str, ParamValue]:
    """The Normal node keeps its direction in its output socket."""
    return {"direction": np.array(node.outputs[0].default_value[:3], np.float32)}


# Kinds of node whose output socket holds a constant: they become constants of what reads them.
CONSTANTS = {"ShaderNodeValue", "ShaderNodeRGB"}

# By kind: what else to tell about a node.
SPECIAL: dict[str, Callable[[bpy.types.Node], dict[str, ParamValue]]] = {
    "ShaderNodeNormal": output_direction,
}


def object_matrix(item: bpy.types.Object) -> dict[str, ParamValue]:
    """The coordinate system of another object: rows of its 3x4 object-to-world matrix."""
    rows = np.array(item.matrix_world, np.float32)[:3]
    return {"object_to_world": np.ascontiguousarray(rows).reshape(-1)}


# By the name of a pointer property: its form.
POINTERS: dict[str, Callable[[bpy.types.bpy_struct], dict[str, ParamValue]]] = {
    "color_ramp": color_ramp,
    "mapping": curve_mapping,
    "object": object_matrix,
}
