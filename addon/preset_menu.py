# mypy: disallow-subclassing-any=False
"""Presets of the render settings: ours, in the folder `presets`, and the user's own."""

from __future__ import annotations

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from .settings import quality_names

FOLDER = "vernier"  # within Blender's folders of presets


class VERNIER_PT_presets(PresetPanel, bpy.types.Panel):  # noqa: N801 - Blender's naming rule
    """The list of presets, in the header of the sampling panel."""

    bl_label = "Vernier Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "render.vernier_preset_add"


class VERNIER_OT_preset_add(AddPresetBase, bpy.types.Operator):  # noqa: N801
    """Add or remove a preset of the render settings"""

    bl_idname = "render.vernier_preset_add"
    bl_label = "Add Vernier Preset"
    preset_menu = "VERNIER_PT_presets"
    preset_subdir = FOLDER
    preset_defines = ["settings = bpy.context.scene.vernier"]  # noqa: RUF012

    @property
    def preset_values(self) -> list[str]:
        return [f"settings.{name}" for name in quality_names()]


_classes = (VERNIER_PT_presets, VERNIER_OT_preset_add)


def register() -> None:
    for item in _classes:
        bpy.utils.register_class(item)
    bpy.utils.register_preset_path(str(Path(__file__).parent))


def unregister() -> None:
    bpy.utils.unregister_preset_path(str(Path(__file__).parent))
    for item in reversed(_classes):
        bpy.utils.unregister_class(item)
