# mypy: disallow-subclassing-any=False
"""The engine's settings at `scene.vernier`, made from the core's one table of parameters."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .command_line import overrides
from .core import CoreMissingError, core

_classes: list[type] = []


def _viewport_rows() -> dict[str, Any]:
    """Settings of the 3D viewport, which the core does not know."""
    return {
        "preview_samples": IntProperty(
            name="Viewport Samples",
            description="Samples per pixel in the 3D viewport",
            default=256,
            min=1,
            max=1 << 24,
            soft_max=4096,
        ),
        "preview_pause": BoolProperty(
            name="Pause Viewport",
            description="Keep what the 3D viewport shows in rendered mode, and take up edits later",
        ),
    }


def _state_rows() -> dict[str, Any]:
    """Where a final render keeps its state, which the core is told when it renders."""
    return {
        "checkpoint": StringProperty(
            name="Checkpoint",
            description="File that keeps the state of final renders: every minute, in the end, and "
            "when cancelled; empty: none",
            subtype="FILE_PATH",
        ),
        "resume": BoolProperty(
            name="Resume",
            description="Go on from the checkpoint, to other samples, time or target error. "
            "The scene must be the same",
        ),
    }


def parameters() -> list[Any]:
    """The core's table of parameters; empty without the core."""
    try:
        return list(core().parameters())
    except CoreMissingError:
        return []


def max_of(name: str) -> int:
    """The largest value of a whole-number setting."""
    return next(int(p.max) for p in parameters() if p.name == name)


def quality_names() -> list[str]:
    """The settings that belong to a quality rather than to a scene, a film or a machine: what
    presets are about."""
    return [p.name for p in parameters() if not p.of_film and p.name not in {"seed", "threads"}]


def _reset_quality(settings: Any) -> None:
    """Sets what presets are about to its defaults."""
    for name in quality_names():
        settings.property_unset(name)


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
    rows |= _viewport_rows() | _state_rows() if rows else {}
    scene_settings = type(
        "VernierSceneSettings",
        (bpy.types.PropertyGroup,),
        {
            "__doc__": "The engine's settings of a scene.",
            "__annotations__": rows,
            "reset_quality": _reset_quality,
        },
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
    given = overrides(parameters())
    names = {"filter": "pixel_filter", "filter_width": "filter_width", "exposure": "film_exposure"}
    return {option: given.get(name, getattr(settings, name)) for option, name in names.items()}


def render_settings(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer
) -> dict[str, bool | int | float | str]:
    """What a session takes, with Blender's own thread count and the view layer's samples."""
    values = {p.name: getattr(scene.vernier, p.name) for p in parameters() if not p.of_film}
    if "threads" in values and not values["threads"] and scene.render.threads_mode == "FIXED":
        values["threads"] = scene.render.threads
    if "samples" in values and view_layer.samples > 0:
        values["samples"] = view_layer.samples
    given = overrides(parameters())
    if given.keys() & {"time_limit", "target_error"} and "samples" not in given:
        values["samples"] = max_of("samples")  # the time or the target alone ends the render
    return values | {name: value for name, value in given.items() if name in values}


def viewport_settings(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer
) -> dict[str, bool | int | float | str]:
    """What a session of the 3D viewport takes, and `pixel`: how many of the region's pixels its
    finest have a side."""
    values = render_settings(scene, view_layer)
    values["samples"] = scene.vernier.preview_samples
    values["time_limit"] = values["target_error"] = 0.0
    size = scene.render.preview_pixel_size
    values["pixel"] = 1 if size == "AUTO" else int(size)
    return values
