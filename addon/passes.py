"""The render passes: the core's table, and the flags by which users ask for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy

from .core import CoreMissingError, core

# By the core's name of a pass: the flag of the view layer that asks for it. With a dot: ours.
_FLAGS = {
    "Depth": "use_pass_z",
    "Position": "use_pass_position",
    "Normal": "use_pass_normal",
    "UV": "use_pass_uv",
    "Diffuse Direct": "use_pass_diffuse_direct",
    "Diffuse Indirect": "use_pass_diffuse_indirect",
    "Diffuse Color": "use_pass_diffuse_color",
    "Glossy Direct": "use_pass_glossy_direct",
    "Glossy Indirect": "use_pass_glossy_indirect",
    "Glossy Color": "use_pass_glossy_color",
    "Transmission Direct": "use_pass_transmission_direct",
    "Transmission Indirect": "use_pass_transmission_indirect",
    "Transmission Color": "use_pass_transmission_color",
    "Emission": "use_pass_emit",
    "Environment": "use_pass_environment",
    "Denoising Normal": "vernier.use_pass_denoising",
    "Denoising Albedo": "vernier.use_pass_denoising",
    "Denoising Depth": "vernier.use_pass_denoising",
    "Debug Sample Count": "vernier.use_pass_sample_count",
    "Error": "vernier.use_pass_error",
}

#: Passes that are worked out when they are read: no sums are kept for them.
DERIVED_PASSES = ("Debug Sample Count", "Error")


@dataclass(frozen=True)
class RenderPass:
    """A pass: the core's name, Blender's name in this version, its channels and their kind."""

    name: str
    blender_name: str
    channels: str  # one letter for each
    kind: str  # COLOR, VECTOR, VALUE


def known_passes() -> list[RenderPass]:
    """All passes of the core, Combined first; only Combined without the core."""
    try:
        rows = list(core().passes())
    except CoreMissingError:
        return [RenderPass("Combined", "Combined", "RGBA", "COLOR")]
    return [_from_core(row) for row in rows]


def _from_core(row: Any) -> RenderPass:
    """A row of the core's table; passes were renamed in Blender 5.0."""
    name = row.name if bpy.app.version >= (5, 0, 0) else row.legacy_name
    return RenderPass(row.name, name, row.channels, row.type)


def wanted_passes(view_layer: bpy.types.ViewLayer) -> list[RenderPass]:
    """The passes that `view_layer` asks for; Combined always."""
    return [p for p in known_passes() if p.name == "Combined" or _is_wanted(view_layer, p.name)]


def _is_wanted(view_layer: bpy.types.ViewLayer, name: str) -> bool:
    value: Any = view_layer
    for part in _FLAGS.get(name, "").split("."):
        value = getattr(value, part, False)
    return bool(value)


def register_passes(
    engine: bpy.types.RenderEngine, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer
) -> None:
    """Tells Blender (the compositor's sockets) which passes there will be."""
    for item in wanted_passes(view_layer):
        engine.register_pass(
            scene, view_layer, item.blender_name, len(item.channels), item.channels, item.kind
        )
