"""Mesh attributes: UV maps, colours, tangents and whatever else a material names."""

from __future__ import annotations

import bpy
import numpy as np
from engine_core.description import Attribute, Domain, FloatArray, IntArray, Mesh

from ..materials.reads import AttributeRead
from .report import Report
from .tangents import tangents

# By Blender's data type: the member that foreach_get reads, its length and its dtype.
_LAYOUTS: dict[str, tuple[str, int, type[np.generic]]] = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int8),
    "BOOLEAN": ("value", 1, np.bool_),
    "FLOAT2": ("vector", 2, np.float32),
    "INT32_2D": ("value", 2, np.int32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
    "QUATERNION": ("value", 4, np.float32),
}
_DOMAINS = {"POINT": Domain.POINT, "FACE": Domain.FACE, "CORNER": Domain.CORNER}


def values(attribute: bpy.types.Attribute) -> FloatArray:
    """The attribute's values as float32, (elements * length,)."""
    member, length, dtype = _LAYOUTS[attribute.data_type]
    data = np.empty(len(attribute.data) * length, dtype)
    attribute.data.foreach_get(member, data)
    return data.astype(np.float32, copy=False)


def integers(attribute: bpy.types.Attribute) -> IntArray:
    """The values of an integer attribute, (elements,)."""
    data = np.empty(len(attribute.data), np.int32)
    attribute.data.foreach_get("value", data)
    return data


def active_uv(mesh: bpy.types.Mesh) -> str:
    """The name of the UV map that renders use where none is named; empty: there is none."""
    for layer in mesh.uv_layers:
        if layer.active_render:
            return str(layer.name)
    return str(mesh.uv_layers[0].name) if mesh.uv_layers else ""


def active_color(mesh: bpy.types.Mesh) -> str:
    """The name of the colour attribute that renders use where none is named; empty: none."""
    layers = mesh.color_attributes
    index = layers.render_color_index
    return str(layers[index].name) if 0 <= index < len(layers) else ""


def read(
    mesh: bpy.types.Mesh, result: Mesh, wanted: AttributeRead, report: Report
) -> Attribute | None:
    """Reads one attribute that a material asks for; None: this mesh does not carry it."""
    name = wanted.name
    if wanted.kind == "color":
        name = name or result.active_color
    if wanted.kind in ("uv", "tangent"):
        name = name or result.active_uv
        if name not in mesh.uv_layers:
            return None
    if wanted.kind == "tangent":
        return Attribute(f"tangent:{name}", Domain.CORNER, tangents(mesh, result, name))
    return _read_generic(mesh, name, result.name, report)


def _read_generic(mesh: bpy.types.Mesh, name: str, owner: str, report: Report) -> Attribute | None:
    attribute = mesh.attributes.get(name) if name else None
    if attribute is None:
        return None
    if attribute.domain not in _DOMAINS or attribute.data_type not in _LAYOUTS:
        report.warn(
            f'object "{owner}": attribute "{name}" ({attribute.data_type.lower()} on '
            f"{attribute.domain.lower()}s) is not supported; materials read 0"
        )
        return None
    data = values(attribute).reshape(-1, _LAYOUTS[attribute.data_type][1])
    if not np.isfinite(data).all():
        report.warn(
            f'object "{owner}": attribute "{name}" holds values that are not finite; '
            "they are read as 0"
        )
        data = np.nan_to_num(data, nan=0.0, posinf=0.0, neginf=0.0)
    return Attribute(name, _DOMAINS[attribute.domain], data)
