"""The engine's settings at `scene.vernier`, made from the core's one table of parameters."""

from __future__ import annotations

from typing import Any

import bpy


def film_settings(scene: bpy.types.Scene) -> dict[str, Any]:
    """The settings that describe the film: `filter` and `exposure` of SyncOptions."""
    settings = getattr(scene, "vernier", None)
    result: dict[str, Any] = {}
    if settings is not None and hasattr(settings, "pixel_filter"):
        result["filter"] = settings.pixel_filter
    if settings is not None and hasattr(settings, "film_exposure"):
        result["exposure"] = settings.film_exposure
    return result
