"""The 3D view's rendered mode: a progressive picture, restarted when something changes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import bpy
import numpy as np
from engine_core.description import Camera, SceneDescription
from mathutils import Matrix

from .core import core
from .session import stats_line
from .settings import film_settings, render_settings
from .sync.camera import rigid
from .sync.depsgraph import SceneSync, SyncOptions

# Seconds between two redraws of a growing picture.
_REDRAW_SECONDS = 0.1


@dataclass(frozen=True)
class View:
    """What a region shows: size in pixels and the matrices, as flat tuples to compare."""

    width: int
    height: int
    view: tuple[float, ...]
    projection: tuple[float, ...]

    @staticmethod
    def of(context: bpy.types.Context) -> View:
        region, data = context.region, context.region_data
        return View(region.width, region.height, _flat(data.view_matrix), _flat(data.window_matrix))


def _flat(matrix: Matrix) -> tuple[float, ...]:
    return tuple(float(value) for row in matrix for value in row)


def view_camera(view: View) -> Camera:
    """The camera of a view, from its view and projection matrices.

    A point at z = -1 with clip coordinate x_c = P00 x + P02 z + P03 and w_c = -z (orthographic: 1)
    lies on the picture's edge where x_c = +-w_c.
    """
    projection = np.array(view.projection, np.float64).reshape(4, 4)
    orthographic = projection[3, 3] != 0.0
    offset = -projection[:2, 3] if orthographic else projection[:2, 2]
    scale = np.array([projection[0, 0], projection[1, 1]])
    low, high = (offset - 1.0) / scale, (offset + 1.0) / scale
    depth, shift = projection[2, 2], projection[2, 3]
    if orthographic:
        near, far = (shift + 1.0) / depth, (shift - 1.0) / depth
    else:
        near, far = shift / (depth - 1.0), shift / (depth + 1.0)
    to_world = Matrix(np.array(view.view).reshape(4, 4).tolist()).inverted()
    return Camera(
        kind="ORTHOGRAPHIC" if orthographic else "PERSPECTIVE",
        transform=rigid(to_world),
        window=(float(low[0]), float(high[0]), float(low[1]), float(high[1])),
        clip_start=float(near),
        clip_end=float(far),
    )


class Viewport:
    """One 3D view's render."""

    def __init__(self, engine: bpy.types.RenderEngine) -> None:
        self._engine = engine
        self._sync = SceneSync()
        self._description: SceneDescription | None = None
        self._session: Any = None
        self._view: View | None = None

    def update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Reads the scene again after an edit, and starts afresh."""
        self._stop()
        self._sync.mark(depsgraph)
        options = SyncOptions(border=False, **film_settings(depsgraph.scene_eval))
        self._description = self._sync.apply(depsgraph, options)
        self._start(View.of(context), depsgraph)

    def draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Draws the current picture, and asks for the next one until it is done."""
        view = View.of(context)
        if view != self._view:
            self._stop()
            self._start(view, depsgraph)
        if self._session is None:
            return
        picture = self._session.read("Combined", 0, 0, view.width, view.height)
        self._show(picture, depsgraph.scene_eval, view)
        progress = self._session.poll(True)
        self._engine.update_stats("", self._session.error_message or stats_line(progress))
        if not progress.done:
            bpy.app.timers.register(self._redraw, first_interval=_REDRAW_SECONDS)

    def _start(self, view: View, depsgraph: bpy.types.Depsgraph) -> None:
        self._view = view
        if self._description is None:
            return
        film = self._description.film
        self._description.camera = view_camera(view)
        self._description.film = replace(
            film, width=view.width, height=view.height, crop=(0, 0, view.width, view.height)
        )
        values = render_settings(depsgraph.scene_eval, depsgraph.view_layer_eval)
        scene = core().compile(self._description, int(values["threads"]))
        self._session = core().Session(scene, values, ["Combined"])
        self._session.start()

    def _stop(self) -> None:
        if self._session is not None:
            self._session.cancel()
            self._session = None

    def _redraw(self) -> None:
        try:
            self._engine.tag_redraw()
        except ReferenceError:  # the view was closed meanwhile
            self._stop()

    def _show(self, picture: np.ndarray, scene: bpy.types.Scene, view: View) -> None:
        import gpu
        from gpu_extras.presets import draw_texture_2d

        pixels = gpu.types.Buffer("FLOAT", picture.size, picture.reshape(-1))
        texture = gpu.types.GPUTexture((view.width, view.height), format="RGBA16F", data=pixels)
        gpu.state.blend_set("ALPHA_PREMULT")
        self._engine.bind_display_space_shader(scene)
        draw_texture_2d(texture, (0, 0), view.width, view.height)
        self._engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")
