"""Socket constants and the implicit conversions between socket types."""

from __future__ import annotations

from itertools import pairwise

import bpy

Constant = float | tuple[float, ...]

# Linear Rec. 709 luminance, as Blender's implicit conversion from colour to value with the default
# working space.
LUMINANCE = (0.2126390059, 0.7151686788, 0.0721923154)
_SCALARS = {"VALUE", "INT", "BOOLEAN"}


def family(socket_type: str) -> str:
    """VALUE, VECTOR, RGBA or SHADER for the types that carry such; else the type itself."""
    return "VALUE" if socket_type in _SCALARS else socket_type


def socket_constant(socket: bpy.types.NodeSocket) -> Constant | None:
    """The socket's own value; None: its type carries none that shading knows."""
    kind = family(socket.type)
    if kind == "VALUE":
        return float(socket.default_value)
    if kind in ("VECTOR", "RGBA"):
        return tuple(float(x) for x in socket.default_value)
    return None


def convert(value: Constant, source: str, target: str) -> Constant:
    """Converts between the families VALUE, VECTOR (3) and RGBA (4), as Cycles does."""
    if source == target:
        return value
    if isinstance(value, float):
        return (value, value, value) if target == "VECTOR" else (value, value, value, 1.0)
    if target == "VECTOR":
        return value[:3]
    if target == "RGBA":
        return (*value[:3], 1.0)
    if source == "RGBA":
        return sum(x * w for x, w in zip(value, LUMINANCE, strict=False))
    return sum(value[:3]) / 3.0


def convert_along(value: Constant, types: list[str]) -> Constant | None:
    """Takes a constant through socket types; None: some type on the way carries no value."""
    families = [family(name) for name in types]
    if any(name not in ("VALUE", "VECTOR", "RGBA") for name in families):
        return None
    for source, target in pairwise(families):
        value = convert(value, source, target)
    return value
