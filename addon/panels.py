# mypy: disallow-subclassing-any=False
"""Blender's own panels, adopted, and a few of ours."""

from __future__ import annotations

import textwrap
from typing import Any

import bpy
from bpy.types import Context, Panel

from .core import CoreMissingError, core
from .engine import VernierRenderEngine
from .preset_menu import VERNIER_PT_presets
from .record import last_modelled
from .settings import parameters

ENGINE = VernierRenderEngine.bl_idname

# Panels for all engines that do not fit: they show what is not used here, or we have our own.
_EXCLUDED = {
    "DATA_PT_light",
    "EEVEE_MATERIAL_PT_viewport_settings",
    "NODE_DATA_PT_light",
    "RENDER_PT_freestyle",
    "RENDER_PT_gpencil",
    "RENDER_PT_simplify_greasepencil",
}
# Panels of single engines that fit.
_INCLUDED = {
    "DATA_PT_EEVEE_light",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "MATERIAL_PT_preview",
    "NODE_DATA_PT_EEVEE_light",
    "VIEWLAYER_PT_override",
}

# Titles of the groups of parameters, in the panels' order; a group that is not here gets its name.
_TITLES = {
    "sampling": "Sampling",
    "light_paths": "Light Paths",
    "bidirectional": "Bidirectional",
    "merging": "Merging",
    "metropolis": "Metropolis",
    "photons": "Photons",
    "film": "Film",
    "performance": "Performance",
}
# Settings, or whole groups, that count only with certain values of another setting.
_ONLY_WITH: dict[str, tuple[str, tuple[str, ...]]] = {
    "whitted_depth": ("integrator", ("WHITTED",)),
    "bidirectional": ("integrator", ("BDPT", "VCM", "AUTO")),
    "merging": ("integrator", ("VCM",)),
    "metropolis": ("integrator", ("PSSMLT", "MMLT", "MLT")),
    "light_fraction": ("direct_light", ("MIXTURE",)),
}
_PASSES = (
    ("Data", ("z", "position", "normal", "uv")),
    ("Light", ("diffuse", "glossy", "transmission")),
    ("", ("emit", "environment")),
)


class _Ours:
    """What our panels share."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {ENGINE}  # noqa: RUF012 - as Blender's panels have it

    @classmethod
    def poll(cls, context: Context) -> bool:
        return bool(context.engine == ENGINE)


def _counts(context: Context, name: str) -> bool:
    """Whether a setting or group changes anything, as the others are."""
    other, values = _ONLY_WITH.get(name, ("", ()))
    return not other or getattr(context.scene.vernier, other, None) in values


def _draw_group(group: str) -> Any:
    """A panel's draw method that shows the settings of one group."""

    def draw(self: Panel, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for parameter in parameters():
            if parameter.group == group and _counts(context, parameter.name):
                layout.prop(context.scene.vernier, parameter.name)
            if parameter.name == "samples":
                layout.prop(context.scene.vernier, "preview_samples")
        if group == "film":
            layout.prop(context.scene.render, "film_transparent", text="Transparent")
        if group == "performance":
            layout.prop(context.scene.vernier, "checkpoint")
            layout.prop(context.scene.vernier, "resume")
            layout.prop(context.scene.render, "preview_pixel_size", text="Viewport Pixel Size")
            layout.prop(context.scene.vernier, "preview_pause")

    return draw


def _group_poll(group: str) -> Any:
    def poll(cls: type, context: Context) -> bool:
        return bool(context.engine == ENGINE) and _counts(context, group)

    return poll


def _draw_presets(self: Panel, context: Context) -> None:
    VERNIER_PT_presets.draw_panel_header(self.layout)


def _group_panels() -> list[type[Panel]]:
    """One panel in the render properties for each group of parameters."""
    groups = list(dict.fromkeys(parameter.group for parameter in parameters()))
    panels = []
    order = [*_TITLES, *groups]
    for group in sorted(groups, key=order.index):
        members = {
            "bl_idname": f"VERNIER_RENDER_PT_{group}",
            "bl_label": _TITLES.get(group, group.replace("_", " ").title()),
            "bl_context": "render",
            "bl_options": set() if group == "sampling" else {"DEFAULT_CLOSED"},
            "draw": _draw_group(group),
        }
        if group == "sampling":
            members["draw_header_preset"] = _draw_presets
        if group in _ONLY_WITH:
            members["poll"] = classmethod(_group_poll(group))
        panels.append(type(members["bl_idname"], (_Ours, Panel), members))
    return panels


class VERNIER_RENDER_PT_missing(_Ours, Panel):  # noqa: N801 - Blender's naming rule
    """What stands in the settings' place when the core cannot be loaded."""

    bl_label = "Vernier"
    bl_context = "render"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return bool(context.engine == ENGINE) and not parameters()

    def draw(self, context: Context) -> None:
        try:
            core()
        except CoreMissingError as error:
            for line in textwrap.wrap(str(error), 50):
                self.layout.label(text=line, icon="ERROR")


class VERNIER_RENDER_PT_modelled(_Ours, Panel):  # noqa: N801
    """What the last render modelled, and what it could leave out."""

    bl_label = "What Was Modelled"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context: Context) -> None:
        modelled = last_modelled()
        if modelled is None:
            self.layout.label(text="Nothing has been rendered yet", icon="INFO")
            return
        for title, statements in (("", modelled.present), ("Left out", modelled.left_out)):
            column = self.layout.column(align=True)
            if title:
                column.label(text=title)
            for statement in statements:
                for line in textwrap.wrap(statement, 50):
                    column.label(text=line, icon="CHECKMARK" if not title else "REMOVE")


class VERNIER_VIEWLAYER_PT_passes(_Ours, Panel):  # noqa: N801
    """The passes that are supported."""

    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layer = context.view_layer
        for title, names in _PASSES:
            column = layout.column(heading=title, align=True)
            for name in names:
                if hasattr(layer, f"use_pass_{name}"):
                    column.prop(layer, f"use_pass_{name}")
                    continue
                row = column.row(heading=name.title(), align=True)
                for part in ("direct", "indirect", "color"):
                    row.prop(layer, f"use_pass_{name}_{part}", text=part.title(), toggle=True)
        column = layout.column(heading="Measurement", align=True)
        for name in ("error", "sample_count", "denoising"):
            column.prop(layer.vernier, f"use_pass_{name}")
        layout.operator("render.vernier_denoise")


class VERNIER_OBJECT_PT_ray_visibility(_Ours, Panel):  # noqa: N801
    """Which rays see an object."""

    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    @classmethod
    def poll(cls, context: Context) -> bool:
        return bool(context.engine == ENGINE and context.object)

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        column = layout.column()
        for name in ("camera", "diffuse", "glossy", "transmission", "shadow"):
            column.prop(context.object, f"visible_{name}", text=name.title())


class VERNIER_WORLD_PT_preview(_Ours, Panel):  # noqa: N801
    """The world on a ball, which the panels of other engines show for themselves."""

    bl_label = "Preview"
    bl_context = "world"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    @classmethod
    def poll(cls, context: Context) -> bool:
        return bool(context.engine == ENGINE and context.world)

    def draw(self, context: Context) -> None:
        self.layout.template_preview(context.world)


class VERNIER_LIGHT_PT_beam(_Ours, Panel):  # noqa: N801
    """What the adopted panel of lights leaves out."""

    bl_label = "Beam"
    bl_context = "data"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return bool(context.engine == ENGINE and context.light)

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(context.light, "use_shadow", text="Cast Shadow")
        if context.light.type == "AREA":
            layout.prop(context.light, "spread")


_FIXED = (
    VERNIER_RENDER_PT_missing,
    VERNIER_RENDER_PT_modelled,
    VERNIER_VIEWLAYER_PT_passes,
    VERNIER_OBJECT_PT_ray_visibility,
    VERNIER_WORLD_PT_preview,
    VERNIER_LIGHT_PT_beam,
)
_registered: list[type[Panel]] = []


def adopted_panels() -> list[type[Panel]]:
    """Blender's panels that are shown for this engine too."""
    return [
        panel
        for panel in _subclasses(Panel)
        if hasattr(panel, "COMPAT_ENGINES")
        and panel not in _registered
        and (
            panel.__name__ in _INCLUDED
            or ("BLENDER_RENDER" in panel.COMPAT_ENGINES and panel.__name__ not in _EXCLUDED)
        )
    ]


def _subclasses(base: type) -> list[type]:
    """All classes below `base`, each once."""
    found: dict[type, None] = {}
    pending: list[type] = list(base.__subclasses__())
    while pending:
        item = pending.pop()
        if item not in found:
            found[item] = None
            pending += item.__subclasses__()
    return list(found)


def register() -> None:
    _registered[:] = [*_group_panels(), *_FIXED]
    for panel in _registered:
        bpy.utils.register_class(panel)
    for panel in adopted_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister() -> None:
    for panel in adopted_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
    for panel in reversed(_registered):
        bpy.utils.unregister_class(panel)
    _registered.clear()
