"""Tangents of UV maps, after MikkTSpace."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from engine_core.description import Domain, FloatArray, Mesh
from numpy.typing import NDArray

Array = NDArray[Any]


def tangents(mesh: bpy.types.Mesh, result: Mesh, uv_map: str) -> FloatArray:
    """Tangents of `uv_map` at the corners, (corners, 4): direction and the bitangent's sign."""
    try:
        mesh.calc_tangents(uvmap=uv_map)
    except RuntimeError:  # Blender refuses meshes with faces of more than four corners
        return _weighted_tangents(mesh, result, uv_map)
    corners = len(mesh.loops)
    data = np.empty((corners, 4), np.float32)
    directions = np.empty((corners, 3), np.float32)
    mesh.loops.foreach_get("tangent", directions.reshape(-1))
    signs = np.empty(corners, np.float32)
    mesh.loops.foreach_get("bitangent_sign", signs)
    mesh.free_tangents()
    data[:, :3], data[:, 3] = np.nan_to_num(directions), signs
    return data


def _weighted_tangents(mesh: bpy.types.Mesh, result: Mesh, uv_map: str) -> FloatArray:
    """The same construction for faces of any size.

    As MikkTSpace does, the faces' tangents are weighted by the corner's angle and summed over
    corners of equal vertex, normal, UV and orientation, then projected onto the normal's plane.
    """
    uv = np.empty((len(mesh.loops), 2), np.float32)
    mesh.attributes[uv_map].data.foreach_get("vector", uv.reshape(-1))
    uv = uv.astype(np.float64)
    vertices = result.corner_vertices
    positions = result.positions.astype(np.float64)[vertices]
    starts = result.face_offsets[:-1]
    sizes = np.diff(result.face_offsets)
    face = np.repeat(np.arange(len(starts)), sizes)
    corner = np.arange(len(vertices))
    after = np.where(corner + 1 == starts[face] + sizes[face], starts[face], corner + 1)
    before = np.where(corner == starts[face], starts[face] + sizes[face] - 1, corner - 1)

    ahead, back = positions[after] - positions, positions[before] - positions
    uv_ahead, uv_back = uv[after] - uv, uv[before] - uv
    area = uv_ahead[:, 0] * uv_back[:, 1] - uv_ahead[:, 1] * uv_back[:, 0]
    orientation = np.where(np.add.reduceat(area, starts) >= 0.0, 1.0, -1.0)[face]
    direction = (ahead * uv_back[:, 1:] - back * uv_ahead[:, 1:]) * orientation[:, None]
    direction = np.add.reduceat(direction, starts)[face]

    normals = _corner_normals(mesh, result, face)
    direction = _normalized(direction - normals * _dot(direction, normals))
    angle = np.arccos(np.clip(_dot(_normalized(ahead), _normalized(back)), -1.0, 1.0))
    keys = np.column_stack((vertices, normals.astype(np.float32), uv, orientation))
    groups, group = np.unique(keys, axis=0, return_inverse=True)
    group = group.reshape(-1)
    sums = np.zeros((len(groups), 3))
    np.add.at(sums, group, direction * angle)
    data = np.empty((len(vertices), 4), np.float32)
    data[:, :3] = _normalized(sums)[group]
    data[:, 3] = orientation
    return data


def _corner_normals(mesh: bpy.types.Mesh, result: Mesh, face: Array) -> Array:
    if result.normals is None:
        normals = np.empty((len(mesh.polygons), 3), np.float32)
        mesh.polygon_normals.foreach_get("vector", normals.reshape(-1))
        return normals[face].astype(np.float64)
    at_corners = result.normal_domain == Domain.CORNER
    normals = result.normals if at_corners else result.normals[result.corner_vertices]
    return normals.astype(np.float64)


def _dot(a: Array, b: Array) -> Array:
    products: Array = np.einsum("ij,ij->i", a, b)[:, None]
    return products


def _normalized(vectors: Array) -> Array:
    """Unit vectors; zero stays zero."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    result: Array = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)
    return result
