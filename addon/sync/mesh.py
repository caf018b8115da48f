"""Evaluated meshes to arrays, at numpy's speed."""

from __future__ import annotations

import bpy
import numpy as np
from engine_core.description import Attribute, Domain, IntArray, Mesh

from ..materials.reads import AttributeRead
from . import attributes
from .report import Report


def read_mesh(
    mesh: bpy.types.Mesh,
    name: str,
    reads: frozenset[AttributeRead],
    slots: int,
    report: Report,
) -> Mesh | None:
    """Reads an evaluated mesh.

    `reads` is what its materials read of it, `slots` the number of its materials (the faces'
    slots are clamped to it, as in Cycles). None: it has no faces, or cannot be rendered, which is
    then reported under `name`.
    """
    if not mesh.polygons:
        return None
    positions = attributes.values(mesh.attributes["position"]).reshape(-1, 3)
    if not np.isfinite(positions).all():
        report.warn(f'object "{name}": its mesh has vertices that are not finite; it is left out')
        return None
    corner_vertices = attributes.integers(mesh.attributes[".corner_vert"])
    face_offsets = _face_offsets(mesh)
    # Before Blender is asked for anything that it computes from them: it would crash.
    if not _are_faces(corner_vertices, face_offsets, len(positions)):
        report.warn(
            f'object "{name}": its mesh has faces of vertices that do not exist; it is left out'
        )
        return None
    result = Mesh(
        name=name,
        positions=positions,
        corner_vertices=corner_vertices,
        face_offsets=face_offsets,
        face_materials=_face_materials(mesh, slots),
    )
    _read_normals(mesh, result, report)
    _read_texture_space(mesh, result)
    result.active_uv = attributes.active_uv(mesh)
    result.active_color = attributes.active_color(mesh)
    result.attributes = _read_attributes(mesh, result, reads, report)
    return result


def _face_offsets(mesh: bpy.types.Mesh) -> IntArray:
    corners, faces = len(mesh.loops), len(mesh.polygons)
    if corners == 3 * faces:  # no face has fewer, so all are triangles
        return np.arange(0, corners + 1, 3, dtype=np.int32)
    # Blender computes these one by one, which is slow.
    offsets = np.empty(faces + 1, np.int32)
    mesh.polygons.foreach_get("loop_start", offsets[:-1])
    offsets[-1] = corners
    return offsets


def _are_faces(corner_vertices: IntArray, face_offsets: IntArray, vertices: int) -> bool:
    """Whether every face has three corners or more, and these are vertices of the mesh."""
    low, high = int(np.min(corner_vertices)), int(np.max(corner_vertices))
    return low >= 0 and high < vertices and int(np.min(np.diff(face_offsets))) >= 3


def _face_materials(mesh: bpy.types.Mesh, slots: int) -> IntArray | None:
    attribute = mesh.attributes.get("material_index")
    if attribute is None or slots <= 1:
        return None
    indices = attributes.integers(attribute)
    np.clip(indices, 0, slots - 1, out=indices)
    return indices if indices.any() else None


def _read_normals(mesh: bpy.types.Mesh, result: Mesh, report: Report) -> None:
    """Takes normals on the coarsest domain that carries all of them."""
    if mesh.normals_domain == "FACE":
        return
    point = mesh.normals_domain == "POINT"
    source = mesh.vertex_normals if point else mesh.corner_normals
    normals = np.empty((len(source), 3), np.float32)
    source.foreach_get("vector", normals.reshape(-1))
    if not np.isfinite(normals).all():
        report.warn(f'object "{result.name}": its normals are not finite; it is shaded flat')
        return
    result.normal_domain = Domain.POINT if point else Domain.CORNER
    result.normals = normals


def _read_texture_space(mesh: bpy.types.Mesh, result: Mesh) -> None:
    """The box of generated coordinates: the undeformed mesh's, where that differs."""
    location, size = mesh.texspace_location, mesh.texspace_size
    low, high = location - size, location + size
    if np.isfinite((*low, *high)).all():
        result.texture_space_min = (low.x, low.y, low.z)
        result.texture_space_max = (high.x, high.y, high.z)


def _read_attributes(
    mesh: bpy.types.Mesh, result: Mesh, reads: frozenset[AttributeRead], report: Report
) -> list[Attribute]:
    found: dict[str, Attribute] = {}
    for read in sorted(reads):
        attribute = attributes.read(mesh, result, read, report)
        if attribute is not None:
            found.setdefault(attribute.name, attribute)
    return list(found.values())
