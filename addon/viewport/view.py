"""What a 3D view shows: its size, its matrices, its border and its lens."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import bpy
import numpy as np
from engine_core.description import Camera, Film
from mathutils import Matrix

from ..sync.camera import Frame, camera_window, read_aperture, rigid

Rectangle = tuple[int, int, int, int]  # x0, y0, x1, y1 in pixels, y upward


@dataclass(frozen=True)
class Lens:
    """Depth of field, as `Camera` has it."""

    aperture_radius: float = 0.0
    focus_distance: float = 10.0
    blades: int = 0
    blade_rotation: float = 0.0
    aperture_ratio: float = 1.0


@dataclass(frozen=True)
class View:
    """What a region shows: size in pixels, the matrices as flat tuples, what part is rendered."""

    width: int
    height: int
    view: tuple[float, ...]
    projection: tuple[float, ...]
    border: Rectangle | None = None  # None: all of it
    lens: Lens = Lens()

    @staticmethod
    def of(context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> View:
        region, data, space = context.region, context.region_data, context.space_data
        view = View(region.width, region.height, _flat(data.view_matrix), _flat(data.window_matrix))
        if data.view_perspective == "CAMERA":
            item = (space.use_local_camera and space.camera) or depsgraph.scene_eval.camera
            if item is None or item.type != "CAMERA":
                return view
            item = item.evaluated_get(depsgraph)
            border = _camera_border(view, item.data, depsgraph.scene_eval.render)
            return replace(view, border=border, lens=_lens(item))
        return replace(view, border=_free_border(view, space))

    @property
    def crop(self) -> Rectangle:
        """The rendered rectangle."""
        return self.border or (0, 0, self.width, self.height)

    def camera(self, pixel: int = 1) -> Camera:
        """The camera for pictures whose pixels are `pixel` of the region's wide and high."""
        camera = view_camera(self)
        left, right, bottom, top = camera.window
        width, height = _scaled(self.width, pixel), _scaled(self.height, pixel)
        # The last column and row may reach beyond the region.
        right = left + (right - left) * width * pixel / self.width
        top = bottom + (top - bottom) * height * pixel / self.height
        lens = self.lens
        return replace(
            camera,
            window=(left, right, bottom, top),
            aperture_radius=lens.aperture_radius,
            focus_distance=lens.focus_distance,
            blades=lens.blades,
            blade_rotation=lens.blade_rotation,
            aperture_ratio=lens.aperture_ratio,
        )

    def film(self, film: Film, pixel: int = 1) -> Film:
        """`film` for this view, with pixels as `camera` has them."""
        x0, y0, x1, y1 = self.crop
        crop = (x0 // pixel, y0 // pixel, _scaled(x1, pixel), _scaled(y1, pixel))
        width, height = _scaled(self.width, pixel), _scaled(self.height, pixel)
        return replace(film, width=width, height=height, crop=crop)


def _scaled(pixels: int, pixel: int) -> int:
    return -(-pixels // pixel)


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


def _lens(item: bpy.types.Object) -> Lens:
    """The depth of field of an evaluated camera object."""
    camera = Camera(kind="ORTHOGRAPHIC" if item.data.type == "ORTHO" else "PERSPECTIVE")
    if item.data.dof.use_dof:
        read_aperture(item.data, item.matrix_world, camera)
    return Lens(
        camera.aperture_radius,
        camera.focus_distance,
        camera.blades,
        camera.blade_rotation,
        camera.aperture_ratio,
    )


def _camera_border(
    view: View, data: bpy.types.Camera, render: bpy.types.RenderSettings
) -> Rectangle | None:
    """Where the render border of the camera's frame lies in the region."""
    if not render.use_border:
        return None
    left, right, bottom, top = camera_window(data, Frame.of(render), data.type == "ORTHO")
    width, height = right - left, top - bottom
    low, high, floor, ceiling = view_camera(view).window

    def column(share: float) -> float:
        return (left + share * width - low) / (high - low)

    def row(share: float) -> float:
        return (bottom + share * height - floor) / (ceiling - floor)

    return _rectangle(
        view,
        column(render.border_min_x),
        row(render.border_min_y),
        column(render.border_max_x),
        row(render.border_max_y),
    )


def _free_border(view: View, space: bpy.types.SpaceView3D) -> Rectangle | None:
    if not space.use_render_border:
        return None
    return _rectangle(
        view,
        space.render_border_min_x,
        space.render_border_min_y,
        space.render_border_max_x,
        space.render_border_max_y,
    )


def _rectangle(view: View, x0: float, y0: float, x1: float, y1: float) -> Rectangle | None:
    """A rectangle given by shares of the region, as pixels within it; None: nothing is left."""
    low_x = min(max(math.floor(x0 * view.width), 0), view.width)
    low_y = min(max(math.floor(y0 * view.height), 0), view.height)
    high_x = min(max(math.ceil(x1 * view.width), 0), view.width)
    high_y = min(max(math.ceil(y1 * view.height), 0), view.height)
    if high_x <= low_x or high_y <= low_y:
        return None
    return low_x, low_y, high_x, high_y
