"""The camera's window against Blender's own projection matrix."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np
import pytest

SIZES = [(64, 48), (40, 90), (50, 50)]


def _projected_corners(scene: Any, camera: Any, window: tuple[float, ...], depth: float) -> Any:
    """Normalised device coordinates of the window's lower left and upper right at `depth`."""
    render = scene.render
    matrix = camera.calc_matrix_camera(
        bpy.context.evaluated_depsgraph_get(),
        x=render.resolution_x,
        y=render.resolution_y,
        scale_x=render.pixel_aspect_x,
        scale_y=render.pixel_aspect_y,
    )
    projection = np.array(matrix, np.float64).reshape(4, 4)
    scale = 1.0 if camera.data.type == "ORTHO" else depth
    left, right, bottom, top = (value * scale for value in window)
    corners = np.array([(left, bottom, -depth, 1.0), (right, top, -depth, 1.0)])
    clip = corners @ projection.T
    return clip[:, :2] / clip[:, 3:]


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("aspect", [(1.0, 1.0), (1.0, 2.0), (1.5, 1.0)])
def test_window_is_the_frame_of_blenders_projection(
    empty_scene: Any, make: Any, export: Any, kind: str, fit: str, size: Any, aspect: Any
) -> None:
    camera = make.camera()
    data = camera.data
    data.type, data.sensor_fit = kind, fit
    data.lens, data.sensor_width, data.sensor_height = 27.0, 31.0, 19.0
    data.ortho_scale, data.shift_x, data.shift_y = 5.0, 0.13, -0.27
    empty_scene.render.resolution_x, empty_scene.render.resolution_y = size
    empty_scene.render.pixel_aspect_x, empty_scene.render.pixel_aspect_y = aspect
    result = export()[0].camera
    assert result.kind == ("PERSPECTIVE" if kind == "PERSP" else "ORTHOGRAPHIC")
    corners = _projected_corners(empty_scene, camera, result.window, 7.0)
    np.testing.assert_allclose(corners, [(-1, -1), (1, 1)], atol=2e-5)


def test_transform_has_no_scale(make: Any, export: Any) -> None:
    camera = make.camera()
    camera.location = (1, 2, 3)
    camera.rotation_euler = (0.3, -0.4, 1.2)
    camera.scale = (2.0, 3.0, 0.5)
    transform = export()[0].camera.transform
    axes = transform[:, :3].astype(np.float64)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-6)
    np.testing.assert_allclose(axes, np.array(camera.rotation_euler.to_matrix()), atol=1e-6)
    np.testing.assert_allclose(transform[:, 3], (1, 2, 3))


def test_camera_scaled_flat_is_still_a_camera(make: Any, export: Any) -> None:
    camera = make.camera()
    camera.scale = (1.0, 0.0, 1.0)
    axes = export()[0].camera.transform[:, :3].astype(np.float64)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-6)


def test_percentage_rounds_down(empty_scene: Any, make: Any, export: Any) -> None:
    make.camera()
    empty_scene.render.resolution_x, empty_scene.render.resolution_y = 101, 55
    empty_scene.render.resolution_percentage = 50
    film = export()[0].film
    assert (film.width, film.height) == (50, 27)


def test_aperture_of_a_perspective_camera(make: Any, export: Any) -> None:
    camera = make.camera()
    camera.data.lens = 50.0
    dof = camera.data.dof
    dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 3.5, 2.0
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 6, 0.25, 1.5
    result = export()[0].camera
    assert result.aperture_radius == pytest.approx(0.05 / 4.0)
    assert result.focus_distance == pytest.approx(3.5)
    assert (result.blades, result.aperture_ratio) == (6, 1.5)
    assert result.blade_rotation == pytest.approx(0.25)


def test_focus_on_an_object_is_measured_along_the_axis(make: Any, export: Any) -> None:
    camera = make.camera()
    camera.location = (0, 0, 10)
    target = make.object("Target", None)
    target.location = (4, 1, 3)
    dof = camera.data.dof
    dof.use_dof, dof.focus_object, dof.aperture_fstop = True, target, 2.0
    result = export()[0].camera
    assert result.focus_distance == pytest.approx(7.0)


def test_aperture_of_an_orthographic_camera(make: Any, export: Any) -> None:
    camera = make.camera()
    camera.data.type = "ORTHO"
    camera.data.dof.use_dof, camera.data.dof.aperture_fstop = True, 4.0
    assert export()[0].camera.aperture_radius == pytest.approx(0.125)


def test_no_depth_of_field_is_a_pinhole(make: Any, export: Any) -> None:
    make.camera()
    assert export()[0].camera.aperture_radius == 0.0


def test_panorama_is_named(make: Any, export: Any) -> None:
    make.camera().data.type = "PANO"
    description, messages = export()
    assert description.camera.kind == "PERSPECTIVE"
    assert messages == [
        'camera "Camera": the lens type pano is not supported; it is drawn as a perspective one'
    ]


def test_no_camera(export: Any) -> None:
    assert export()[0].camera is None


@pytest.mark.parametrize("perspective", [True, False])
def test_view_camera_inverts_a_projection(perspective: bool) -> None:
    """The 3D view's matrices give back the window they were made from."""
    from addon.viewport.view import View, view_camera

    left, right, bottom, top, near, far = -0.3, 0.5, -0.2, 0.4, 0.1, 100.0
    if perspective:
        edges = tuple(near * value for value in (left, right, bottom, top))
        matrix = _frustum(*edges, near, far)
    else:
        matrix = _box(left, right, bottom, top, near, far)
    flat = tuple(matrix.reshape(-1))
    camera = view_camera(View(8, 6, tuple(np.eye(4).reshape(-1)), flat))
    assert camera.window == pytest.approx((left, right, bottom, top))
    assert (camera.clip_start, camera.clip_end) == pytest.approx((near, far), rel=1e-3)
    assert camera.kind == ("PERSPECTIVE" if perspective else "ORTHOGRAPHIC")


def _frustum(l: float, r: float, b: float, t: float, n: float, f: float) -> Any:  # noqa: E741
    """OpenGL's glFrustum."""
    return np.array(
        [
            (2 * n / (r - l), 0, (r + l) / (r - l), 0),
            (0, 2 * n / (t - b), (t + b) / (t - b), 0),
            (0, 0, -(f + n) / (f - n), -2 * f * n / (f - n)),
            (0, 0, -1, 0),
        ]
    )


def _box(l: float, r: float, b: float, t: float, n: float, f: float) -> Any:  # noqa: E741
    """OpenGL's glOrtho."""
    return np.array(
        [
            (2 / (r - l), 0, 0, -(r + l) / (r - l)),
            (0, 2 / (t - b), 0, -(t + b) / (t - b)),
            (0, 0, -2 / (f - n), -(f + n) / (f - n)),
            (0, 0, 0, 1),
        ]
    )


def test_window_of_the_default_camera() -> None:
    """50 mm on a 36 mm sensor: the tangent of half the angle of view is 0.36."""
    assert math.tan(0.5 * bpy.data.cameras.new("Plain").angle_x) == pytest.approx(0.36)
