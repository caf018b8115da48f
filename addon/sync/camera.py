"""Blender's camera to the description's window on the plane z = -1."""

from __future__ import annotations

import math
from dataclasses import dataclass

import bpy
import numpy as np
from engine_core.description import Camera
from mathutils import Matrix

from .report import Report

# Blender's lowest f-number that Cycles accepts; below it apertures would be infinite.
_MIN_FSTOP = 1e-5


@dataclass(frozen=True)
class Frame:
    """The full picture in pixels, and the pixels' aspect."""

    width: int
    height: int
    aspect_x: float = 1.0
    aspect_y: float = 1.0

    @staticmethod
    def of(render: bpy.types.RenderSettings) -> Frame:
        """The picture's size as Blender rounds it."""
        percent = render.resolution_percentage
        return Frame(
            max(1, render.resolution_x * percent // 100),
            max(1, render.resolution_y * percent // 100),
            render.pixel_aspect_x,
            render.pixel_aspect_y,
        )


def read_camera(item: bpy.types.Object, matrix: Matrix, frame: Frame, report: Report) -> Camera:
    """Reads an evaluated camera object; `matrix` is its camera-to-world matrix."""
    data = item.data
    orthographic = data.type == "ORTHO"
    if data.type not in ("PERSP", "ORTHO"):
        report.warn(
            f'camera "{item.name}": the lens type {data.type.lower()} is not supported; '
            "it is drawn as a perspective one"
        )
    camera = Camera(
        kind="ORTHOGRAPHIC" if orthographic else "PERSPECTIVE",
        transform=rigid(matrix),
        window=camera_window(data, frame, orthographic),
        clip_start=float(data.clip_start),
        clip_end=float(data.clip_end),
    )
    if data.dof.use_dof:
        read_aperture(data, matrix, camera)
    return camera


def camera_window(
    data: bpy.types.Camera, frame: Frame, orthographic: bool
) -> tuple[float, float, float, float]:
    """Left, right, bottom, top: `lens`, sensor fit and shift as Blender's camera applies them.

    The fitted side spans sensor / lens (orthographic: the scale); shifts are fractions of it.
    """
    width, height = frame.width * frame.aspect_x, frame.height * frame.aspect_y
    fit = data.sensor_fit
    horizontal = width >= height if fit == "AUTO" else fit == "HORIZONTAL"
    sensor = data.sensor_height if fit == "VERTICAL" else data.sensor_width
    span = data.ortho_scale if orthographic else sensor / data.lens
    pixel = span / (width if horizontal else height)
    half_width, half_height = 0.5 * pixel * width, 0.5 * pixel * height
    x, y = data.shift_x * span, data.shift_y * span
    return (x - half_width, x + half_width, y - half_height, y + half_height)


def read_aperture(data: bpy.types.Camera, matrix: Matrix, camera: Camera) -> None:
    """Depth of field by Cycles' convention: an aperture of lens / f-number, in metres."""
    dof = data.dof
    fstop = max(float(dof.aperture_fstop), _MIN_FSTOP)
    focal = 1.0 if camera.kind == "ORTHOGRAPHIC" else 1e-3 * float(data.lens)
    distance = _focus_distance(dof, matrix)
    if not distance > 0.0:
        return
    camera.aperture_radius = focal / (2.0 * fstop)
    camera.focus_distance = distance
    camera.blades = int(dof.aperture_blades) if dof.aperture_blades >= 3 else 0
    camera.blade_rotation = float(dof.aperture_rotation)
    camera.aperture_ratio = float(dof.aperture_ratio)


def _focus_distance(dof: bpy.types.CameraDOFSettings, matrix: Matrix) -> float:
    """Metres along the view axis."""
    target = dof.focus_object
    if target is None:
        return float(dof.focus_distance)
    place = target.matrix_world
    bone = target.pose.bones.get(dof.focus_subtarget) if target.pose is not None else None
    if bone is not None:
        place = place @ bone.matrix
    axis = matrix.to_3x3().col[2].normalized()
    return abs(float((matrix.translation - place.translation).dot(axis)))


def rigid(matrix: Matrix) -> np.ndarray:
    """The first three rows of a matrix without its scale, (3, 4) float32; flat axes are rebuilt."""
    result = np.array(matrix, np.float64)[:3]
    axes = result[:, :3]
    lengths = np.linalg.norm(axes, axis=0)
    if np.all(lengths > 0.0) and math.isfinite(float(lengths.sum())):
        result[:, :3] = axes / lengths
    else:
        result[:, :3] = np.array(matrix.to_quaternion().to_matrix(), np.float64)
    return np.ascontiguousarray(result, np.float32)
