# mypy: disallow-subclassing-any=False
"""The engine's settings at `scene.vernier`, made from the core's one table of parameters."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

from .core import CoreMissingError, core

_classes: list[type] = []


def parameters() -> list[Any]:
    """The core's table of parameters; empty without the core."""
    try:
        return list(core().parameters())
    except CoreMissingError:
        return []


def _property(parameter: Any) -> Any:
    """The Blender property of one parameter."""
    texts = {"name": parameter.label, "description": parameter.description}
    if parameter.type == "enum":
        items = [(key, label, about) for key, label, about in parameter.items]
        return EnumProperty(items=items, default=parameter.default, **texts)
    if parameter.type == "bool":
        return BoolProperty(default=bool(parameter.default), **texts)
    if parameter.type == "int":
        return IntProperty(
            default=int(parameter.default),
            min=int(parameter.min),
            max=int(parameter.max),
            soft_min=int(parameter.soft_min),
            soft_max=int(parameter.soft_max),
            **texts,
        )
    units = {"s": {"unit": "TIME_ABSOLUTE"}, "px": {"subtype": "PIXEL"}}
    return FloatProperty(
        default=parameter.default,
        min=parameter.min,
        max=parameter.max,
        soft_min=parameter.soft_min,
        soft_max=parameter.soft_max,
        precision=3,
        **units.get(parameter.unit, {}),
        **texts,
    )


class VernierViewLayerSettings(bpy.types.PropertyGroup):
    """What a view layer has of ours: the passes that Blender itself has no flag for."""

    use_pass_error: BoolProperty(  # type: ignore[valid-type]
        name="Error",
        description="Half-width of each pixel's 95 % confidence interval, relative to the pixel",
    )
    use_pass_sample_count: BoolProperty(  # type: ignore[valid-type]
        name="Sample Count", description="Samples taken per pixel"
    )
    use_pass_denoising: BoolProperty(  # type: ignore[valid-type]
        name="Denoising Data", description="Normal, albedo and depth as denoisers read them"
    )


def register() -> None:
    rows = {parameter.name: _property(parameter) for parameter in parameters()}
    scene_settings = type(
        "VernierSceneSettings",
        (bpy.types.PropertyGroup,),
        {"__doc__": "The engine's settings of a scene.", "__annotations__": rows},
    )
    _classes[:] = [scene_settings, VernierViewLayerSettings]
    for item in _classes:
        bpy.utils.register_class(item)
    bpy.types.Scene.vernier = PointerProperty(type=scene_settings, name="Vernier")
    bpy.types.ViewLayer.vernier = PointerProperty(type=VernierViewLayerSettings, name="Vernier")


def unregister() -> None:
    del bpy.types.ViewLayer.vernier
    del bpy.types.Scene.vernier
    for item in reversed(_classes):
        bpy.utils.unregister_class(item)
    _classes.clear()


def film_settings(scene: bpy.types.Scene) -> dict[str, Any]:
    """The settings that describe the film: members of SyncOptions.

    None while there is no core, or the add-on is not registered: scenes can be described, with the
    defaults, even then.
    """
    settings: Any = getattr(scene, "vernier", None)
    if not hasattr(settings, "pixel_filter"):
        return {}
    return {
        "filter": settings.pixel_filter,
        "filter_width": settings.filter_width,
        "exposure": settings.film_exposure,
    }


def render_settings(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer
) -> dict[str, bool | int | float | str]:
    """What a session takes, with Blender's own thread count and the view layer's samples."""
    values = {p.name: getattr(scene.vernier, p.name) for p in parameters() if not p.of_film}
    if "threads" in values and not values["threads"] and scene.render.threads_mode == "FIXED":
        values["threads"] = scene.render.threads
    if "samples" in values and view_layer.samples > 0:
        values["samples"] = view_layer.samples
    return values
