"""Meshes made from numbers: boxes, grids, lathed profiles, tubes and spheres. Lengths in metres."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import bpy
from mathutils import Vector

Point = Sequence[float]
UvOf = Callable[[Vector], tuple[float, float]]


def polygons(
    name: str,
    vertices: Sequence[Point],
    faces: Sequence[Sequence[int]],
    *,
    smooth: bool = False,
    uvs: Sequence[tuple[float, float]] | None = None,
) -> bpy.types.Mesh:
    """Makes a mesh; `uvs` holds one pair per face corner, in the order of `faces`."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(v) for v in vertices], [], [tuple(f) for f in faces])
    if uvs is not None:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", [value for uv in uvs for value in uv])
    if smooth:
        mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.update()
    if mesh.validate():
        raise ValueError(f"mesh {name} has invalid faces")
    return mesh


def quad(name: str, a: Point, b: Point, c: Point, d: Point) -> bpy.types.Mesh:
    """One quadrilateral with UVs in metres along its first and last edge."""
    width = (Vector(b) - Vector(a)).length
    height = (Vector(d) - Vector(a)).length
    uvs = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    return polygons(name, [a, b, c, d], [(0, 1, 2, 3)], uvs=uvs)


_BOX_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (1, 2, 6, 5), (3, 0, 4, 7))
_BOX_AXES = ((0, 1), (0, 1), (0, 2), (0, 2), (1, 2), (1, 2))


def boxes(name: str, bounds: Sequence[tuple[Point, Point]]) -> bpy.types.Mesh:
    """One mesh of axis-aligned boxes, each given by two corners; UVs in metres per face."""
    vertices: list[Point] = []
    faces: list[tuple[int, ...]] = []
    uvs: list[tuple[float, float]] = []
    for low, high in bounds:
        first = len(vertices)
        (x0, y0, z0), (x1, y1, z1) = low, high
        corners = [
            (x0, y0, z0),
            (x1, y0, z0),
            (x1, y1, z0),
            (x0, y1, z0),
            (x0, y0, z1),
            (x1, y0, z1),
            (x1, y1, z1),
            (x0, y1, z1),
        ]
        vertices += corners
        for face, (u, v) in zip(_BOX_FACES, _BOX_AXES, strict=True):
            faces.append(tuple(first + index for index in face))
            uvs += [(corners[index][u], corners[index][v]) for index in face]
    return polygons(name, vertices, faces, uvs=uvs)


def box(name: str, size: Point, *, on_floor: bool = True) -> bpy.types.Mesh:
    """A box of `size` centred on the origin, standing on z = 0 if `on_floor`."""
    x, y, z = (value / 2 for value in size)
    lift = z if on_floor else 0.0
    return boxes(name, [((-x, -y, lift - z), (x, y, lift + z))])


def grid(
    name: str,
    size: tuple[float, float],
    cells: tuple[int, int],
    height: Callable[[float, float], float] = lambda x, y: 0.0,
    *,
    smooth: bool = True,
) -> bpy.types.Mesh:
    """A height field centred on the origin, normals up, UVs from 0 to 1."""
    columns, rows = cells
    vertices = []
    for row in range(rows + 1):
        for column in range(columns + 1):
            x = size[0] * (column / columns - 0.5)
            y = size[1] * (row / rows - 0.5)
            vertices.append((x, y, height(x, y)))
    stride = columns + 1
    faces = [
        (j * stride + i, j * stride + i + 1, (j + 1) * stride + i + 1, (j + 1) * stride + i)
        for j in range(rows)
        for i in range(columns)
    ]
    uvs = [
        ((index % stride) / columns, (index // stride) / rows) for face in faces for index in face
    ]
    return polygons(name, vertices, faces, smooth=smooth, uvs=uvs)


def spline(points: Sequence[Point], steps: int) -> list[Vector]:
    """Samples the Catmull-Rom spline through `points`, `steps` per span."""
    knots = [Vector(p) for p in points]
    knots = [2 * knots[0] - knots[1], *knots, 2 * knots[-1] - knots[-2]]
    samples = []
    for i in range(1, len(knots) - 2):
        p0, p1, p2, p3 = knots[i - 1 : i + 3]
        for step in range(steps):
            t = step / steps
            samples.append(
                0.5
                * (
                    2 * p1
                    + (p2 - p0) * t
                    + (2 * p0 - 5 * p1 + 4 * p2 - p3) * t * t
                    + (3 * p1 - p0 - 3 * p2 + p3) * t**3
                )
            )
    return [*samples, knots[-2]]


def lathe(
    name: str,
    profile: Sequence[tuple[float, float]],
    segments: int = 48,
    *,
    closed: bool = False,
    smooth: bool = True,
) -> bpy.types.Mesh:
    """Turns a profile of (radius, z) about Z; normals point right of the profile's direction.

    A profile going up along the outside has outward normals. Points of radius 0 become poles; a
    `closed` profile joins its last point to its first (a ring, or the wall of a vessel).
    """
    vertices: list[Point] = []
    rings: list[list[int]] = []
    for radius, z in profile:
        if radius == 0.0:
            rings.append([len(vertices)] * (segments + 1))
            vertices.append((0.0, 0.0, z))
            continue
        first = len(vertices)
        for i in range(segments):
            angle = 2 * math.pi * i / segments
            vertices.append((radius * math.cos(angle), radius * math.sin(angle), z))
        rings.append([*range(first, first + segments), first])
    pairs = list(pairwise(rings)) + ([(rings[-1], rings[0])] if closed else [])
    faces: list[list[int]] = []
    uvs: list[tuple[float, float]] = []
    for row, (low, high) in enumerate(pairs):
        for i in range(segments):
            corners = [
                (low[i], i, row),
                (low[i + 1], i + 1, row),
                (high[i + 1], i + 1, row + 1),
                (high[i], i, row + 1),
            ]
            unique = [c for k, c in enumerate(corners) if c[0] != corners[k - 1][0]]
            if len(unique) > 2:
                faces.append([c[0] for c in unique])
                uvs += [(c[1] / segments, c[2] / len(pairs)) for c in unique]
    return polygons(name, vertices, faces, smooth=smooth, uvs=uvs)


def ball(name: str, radius: float, segments: int = 48, rings: int = 24) -> bpy.types.Mesh:
    """A sphere about the origin."""
    profile = [
        (radius * math.sin(math.pi * i / rings), -radius * math.cos(math.pi * i / rings))
        for i in range(rings + 1)
    ]
    profile[0], profile[-1] = (0.0, -radius), (0.0, radius)
    return lathe(name, profile, segments)


def cylinder(name: str, radius: float, height: float, segments: int = 32) -> bpy.types.Mesh:
    """A closed cylinder standing on z = 0, flat shaded (add a bevel to round its rims)."""
    profile = [(0.0, 0.0), (radius, 0.0), (radius, height), (0.0, height)]
    return lathe(name, profile, segments, smooth=False)


def tube(
    name: str,
    path: Sequence[Point],
    radii: Sequence[float] | float,
    segments: int = 12,
    *,
    loop: bool = False,
) -> bpy.types.Mesh:
    """Sweeps a circle along a path, by parallel transport of its frame; ends are closed."""
    points = [Vector(p) for p in path]
    count = len(points)
    widths = [radii] * count if isinstance(radii, int | float) else list(radii)
    tangents = []
    for i in range(count):
        before = points[(i - 1) % count] if loop or i > 0 else points[i]
        after = points[(i + 1) % count] if loop or i < count - 1 else points[i]
        tangents.append((after - before).normalized())
    side = tangents[0].orthogonal().normalized()
    vertices: list[Point] = []
    for point, tangent, width in zip(points, tangents, widths, strict=True):
        side = (side - tangent * side.dot(tangent)).normalized()
        other = tangent.cross(side)
        for k in range(segments):
            angle = 2 * math.pi * k / segments
            vertices.append(point + width * (math.cos(angle) * side + math.sin(angle) * other))
    faces: list[Sequence[int]] = []
    uvs: list[tuple[float, float]] = []
    for i in range(count if loop else count - 1):
        low, high = i * segments, ((i + 1) % count) * segments
        for k in range(segments):
            n = (k + 1) % segments
            faces.append((low + k, low + n, high + n, high + k))
            uvs += [
                (k / segments, i / count),
                ((k + 1) / segments, i / count),
                ((k + 1) / segments, (i + 1) / count),
                (k / segments, (i + 1) / count),
            ]
    if not loop:
        last = (count - 1) * segments
        faces.append(tuple(reversed(range(segments))))
        faces.append(tuple(range(last, last + segments)))
        uvs += [(0.0, 0.0)] * (2 * segments)
    return polygons(name, vertices, faces, smooth=True, uvs=uvs)


def joined(name: str, meshes: Sequence[bpy.types.Mesh]) -> bpy.types.Mesh:
    """Merges meshes (shading kept, materials dropped) into one and removes the parts."""
    vertices: list[Point] = []
    faces: list[list[int]] = []
    smooth: list[bool] = []
    uvs: list[tuple[float, float]] = []
    for mesh in meshes:
        first = len(vertices)
        vertices += [tuple(v.co) for v in mesh.vertices]
        faces += [[first + index for index in p.vertices] for p in mesh.polygons]
        smooth += [p.use_smooth for p in mesh.polygons]
        uvs += [tuple(item.uv) for item in mesh.uv_layers[0].data]
        bpy.data.meshes.remove(mesh)
    result = polygons(name, vertices, faces, uvs=uvs)
    result.polygons.foreach_set("use_smooth", smooth)
    return result
