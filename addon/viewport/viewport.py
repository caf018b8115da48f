"""One 3D view's render, from Blender's side: reads edits, draws what there is, keeps it moving."""

from __future__ import annotations

import time
import weakref
from typing import Any

import bpy

from ..progress import stats_line
from ..settings import film_settings, viewport_settings
from ..sync.depsgraph import SceneSync, SyncOptions
from .display import Display
from .pictures import Picture, PictureMaker, Request
from .view import View

# Seconds between two looks for something new to draw.
_TICK_SECONDS = 1.0 / 60.0
# Share of the time that may go into redrawing a picture that only gets smoother.
_DISPLAY_SHARE = 0.1
# Least seconds between two such redraws, and between two estimates of the error.
_REFRESH_SECONDS = 0.1
_STATS_SECONDS = 1.0


class Viewport:
    """Lives as long as the engine instance of its 3D view, to which it keeps no strong reference:
    Blender frees that one when the view leaves rendered mode."""

    def __init__(self, engine: bpy.types.RenderEngine) -> None:
        self._engine = weakref.ref(engine)
        self._sync = SceneSync()
        self._maker = PictureMaker()
        weakref.finalize(engine, self._maker.close)
        self._display = Display()
        self._view: View | None = None
        self._values: dict[str, Any] = {}
        self._drawn: Picture | None = None
        self._next_refresh = 0.0
        self._next_stats = 0.0
        self._finished = False  # the drawn picture has its last sample
        self._told = False  # and its stats are shown
        self._error = ""  # what is shown in their place
        self._ticking = False

    def update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Reads the scene again after an edit; the picture goes on until the new one is there."""
        self._view = View.of(context, depsgraph)
        if depsgraph.scene_eval.vernier.preview_pause:
            self._sync.mark(depsgraph)  # to be read when the pause ends
            return
        self._values = viewport_settings(depsgraph.scene_eval, depsgraph.view_layer_eval)
        description = None
        if self._drawn is None or not only_view_changed(depsgraph):
            self._sync.mark(depsgraph)
            options = SyncOptions(border=False, **film_settings(depsgraph.scene_eval))
            description = self._sync.apply(depsgraph, options)
        self._maker.ask(Request(self._view, self._values, description))
        self._keep_ticking()

    def draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Draws the newest picture, and asks for another one when the view is not its."""
        engine = self._engine()
        view = View.of(context, depsgraph)
        if view != self._view and not depsgraph.scene_eval.vernier.preview_pause:
            self._view = view
            self._maker.ask(Request(view, self._values, moved=True))
            self._keep_ticking()
        picture = self._maker.shown
        if engine is None:
            return
        self._show_error(engine, picture)
        if picture is None:
            return
        start = time.perf_counter()
        fresh = picture is self._drawn and not self._finished and start >= self._next_refresh
        if fresh:
            self._finished = bool(picture.session.poll().done)
        elif picture is not self._drawn:
            self._finished = self._told = False
            self._next_stats = 0.0
        self._display.draw(picture, fresh, engine, depsgraph.scene_eval)
        self._drawn = picture
        spent = time.perf_counter() - start
        if fresh:
            self._next_refresh = start + max(_REFRESH_SECONDS, spent / _DISPLAY_SHARE)
        self._show_stats(engine, picture)

    def _show_error(self, engine: bpy.types.RenderEngine, picture: Picture | None) -> None:
        error = self._maker.error or (picture.session.error_message if picture else "")
        if error and error != self._error:
            engine.update_stats("", error)
        self._error = error

    def _show_stats(self, engine: bpy.types.RenderEngine, picture: Picture) -> None:
        now = time.perf_counter()
        if self._error:
            return
        if picture.pixel > self._values["pixel"]:  # a coarse one of a single sample
            engine.update_stats("", f"Sample 0/{self._values['samples']}")
            return
        if not self._told and (now >= self._next_stats or self._finished):
            engine.update_stats("", stats_line(picture.session.poll(True)))
            self._next_stats = now + _STATS_SECONDS
            self._told = self._finished

    def _keep_ticking(self) -> None:
        if not self._ticking:
            self._ticking = True
            bpy.app.timers.register(self._tick, first_interval=_TICK_SECONDS)

    def _tick(self) -> float | None:
        """Asks Blender for a redraw when there is something to draw; ends when all is drawn."""
        engine = self._engine()
        try:
            if engine is None:
                return None
            picture = self._maker.shown
            changed = picture is not self._drawn or self._maker.error not in ("", self._error)
            if changed or (not self._finished and time.perf_counter() >= self._next_refresh):
                engine.tag_redraw()
            if self._finished and not self._maker.busy and not changed:
                self._ticking = False
                return None
        except ReferenceError:  # Blender has freed the engine
            self._maker.close()
            return None
        return _TICK_SECONDS


def only_view_changed(depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether the updates are of cameras alone: what they show follows from the view's matrices."""
    found = False
    for update in depsgraph.updates:
        item = update.id
        is_camera = isinstance(item, bpy.types.Camera) or (
            isinstance(item, bpy.types.Object) and item.type == "CAMERA"
        )
        if not is_camera:
            return False
        found = True
    return found
