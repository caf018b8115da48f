# mypy: disallow-subclassing-any=False
"""The render engine as Blender sees it: every method delegates."""

from __future__ import annotations

import importlib
from typing import Any

import bpy

from .command_line import render_failed
from .core import CoreMissingError, core, has_core
from .passes import register_passes


class VernierRenderEngine(bpy.types.RenderEngine):
    """Vernier."""

    bl_idname = "VERNIER"
    bl_label = "Vernier"
    bl_use_preview = True
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True
    bl_use_spherical_stereo = False

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._render: Any = None
        self._viewport: Any = None

    def update(self, data: bpy.types.BlendData, depsgraph: bpy.types.Depsgraph) -> None:
        """Nothing: `render` reads the depsgraph of its view layer."""

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Renders one view layer of one frame."""
        try:
            core()
            from .session import FinalRender

            if self._render is None:
                self._render = FinalRender(self)
            self._render.run(depsgraph)
        except CoreMissingError as error:
            fail(self, str(error))
        except Exception as error:
            # Blender swallows exceptions of engines and calls the picture finished.
            import traceback

            traceback.print_exc()
            fail(self, f"Vernier failed: {error}")

    def update_render_passes(
        self, scene: bpy.types.Scene | None = None, renderlayer: bpy.types.ViewLayer | None = None
    ) -> None:
        register_passes(self, scene, renderlayer)

    def view_update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        try:
            core()
            from .viewport.viewport import Viewport

            if self._viewport is None:
                self._viewport = Viewport(self)
            self._viewport.update(context, depsgraph)
        except Exception as error:  # CoreMissingError, or what a scene makes of Blender's data
            self._show_in_viewport(error)

    def view_draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        if self._viewport is None:
            return
        try:
            self._viewport.draw(context, depsgraph)
        except Exception as error:
            self._show_in_viewport(error)

    def _show_in_viewport(self, error: Exception) -> None:
        if not isinstance(error, CoreMissingError):
            import traceback

            traceback.print_exc()
        self.update_stats("Vernier", str(error))


def fail(engine: bpy.types.RenderEngine, message: str) -> None:
    """Makes a failure visible: `error_set` in the window, the report as an exception to scripts."""
    if not engine.is_preview:
        render_failed()
    engine.error_set(message)
    engine.report({"ERROR"}, message)


def register() -> None:
    bpy.utils.register_class(VernierRenderEngine)
    if has_core():
        # Read now: the first render's time is not the place for it.
        importlib.import_module(".session", __package__)


def unregister() -> None:
    bpy.utils.unregister_class(VernierRenderEngine)
