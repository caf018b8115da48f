"""Scene descriptions without rendering."""

from __future__ import annotations

import bpy
from engine_core.description import SceneDescription

from .settings import film_settings
from .sync.depsgraph import SceneSync, SyncOptions


def export_scene(
    depsgraph: bpy.types.Depsgraph, *, border: bool = True
) -> tuple[SceneDescription, list[str]]:
    """Describes the depsgraph's scene and view layer.

    `border` False: the whole frame, whatever the render border. Returns the description and what
    sync has to tell the user. Read visibility as the depsgraph's mode has it: a viewport's hides
    what the viewport hides.
    """
    sync = SceneSync()
    options = SyncOptions(border=border, **film_settings(depsgraph.scene_eval))
    description = sync.apply(depsgraph, options)
    return description, sync.report.messages
