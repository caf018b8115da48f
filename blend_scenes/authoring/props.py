"""Furniture and vessels that several scenes use. All stand on z = 0 about the origin, in metres."""

from __future__ import annotations

import math
from collections.abc import Sequence

import bpy
from mathutils import Vector

from .common import add_bevel, add_object, add_subdivision
from .shapes import Point, box, boxes, joined, lathe, polygons, spline, tube


def _profile(points: Sequence[tuple[float, float]], steps: int = 6) -> list[tuple[float, float]]:
    """Smooths a lathe profile; radii never fall below 0, ends on the axis stay on it."""
    samples = spline([(r, 0.0, z) for r, z in points], steps)
    smooth = [(max(p.x, 0.001), p.z) for p in samples]
    for end, source in ((0, points[0]), (-1, points[-1])):
        smooth[end] = (source[0], source[1])
    return smooth


def teapot(name: str, size: float = 1.0) -> bpy.types.Mesh:
    """A round teapot with lid, spout (towards +X) and handle; 0.2 m wide at size 1."""
    s = size
    body = lathe(
        "body",
        [
            (r * s, z * s)
            for r, z in _profile(
                [
                    (0.0, 0.0),
                    (0.055, 0.0),
                    (0.066, 0.006),
                    (0.088, 0.035),
                    (0.097, 0.068),
                    (0.085, 0.102),
                    (0.058, 0.126),
                ]
            )
        ],
    )
    lid = lathe(
        "lid",
        [
            (r * s, z * s)
            for r, z in _profile(
                [
                    (0.062, 0.120),
                    (0.063, 0.128),
                    (0.045, 0.140),
                    (0.018, 0.148),
                    (0.009, 0.155),
                    (0.014, 0.166),
                    (0.009, 0.176),
                    (0.0, 0.178),
                ]
            )
        ],
    )
    spout_path = spline(
        [
            Vector(p) * s
            for p in ((0.075, 0, 0.045), (0.115, 0, 0.062), (0.138, 0, 0.100), (0.168, 0, 0.125))
        ],
        6,
    )
    count = len(spout_path)
    radii = [s * (0.027 - 0.016 * (i / (count - 1)) ** 0.7) for i in range(count)]
    spout = tube("spout", spout_path, radii, 20)
    handle = tube(
        "handle",
        spline(
            [
                Vector(p) * s
                for p in (
                    (-0.078, 0, 0.104),
                    (-0.125, 0, 0.118),
                    (-0.150, 0, 0.085),
                    (-0.128, 0, 0.046),
                    (-0.086, 0, 0.034),
                )
            ],
            8,
        ),
        0.0085 * s,
        14,
    )
    return joined(name, [body, lid, spout, handle])


def vessel(
    name: str,
    outside: Sequence[tuple[float, float]],
    wall: float,
    *,
    bottom: float | None = None,
    segments: int = 64,
) -> bpy.types.Mesh:
    """A vessel of revolution with a real wall: outer profile, rim, inner profile.

    `outside` runs from the axis at the foot up to the rim; `wall` is the thickness and `bottom`
    the height at which the hollow begins (default: the wall's thickness above the foot).
    """
    outer = _profile(outside)
    low = outer[0][1] + (wall if bottom is None else bottom)
    inner: list[tuple[float, float]] = []
    for i in range(len(outer) - 1, 0, -1):
        r, z = outer[i]
        before, after = outer[i - 1], outer[min(i + 1, len(outer) - 1)]
        along = Vector((after[0] - before[0], after[1] - before[1])).normalized()
        r, z = r - wall * along.y, z + wall * along.x * (1 if i < len(outer) - 1 else 0)
        if z > low and r > wall:
            inner.append((r, z))
    rim_r, rim_z = outer[-1]
    rim = [(rim_r - 0.5 * wall, rim_z + 0.4 * wall)]
    return lathe(name, [*outer, *rim, *inner, (0.0, low)], segments)


def goblet(name: str) -> bpy.types.Mesh:
    """A wine glass with a stem, 0.19 m tall."""
    outside = [
        (0.0, 0.0),
        (0.036, 0.0),
        (0.037, 0.003),
        (0.012, 0.008),
        (0.005, 0.018),
        (0.0042, 0.075),
        (0.010, 0.085),
        (0.034, 0.108),
        (0.042, 0.140),
        (0.037, 0.175),
        (0.033, 0.190),
    ]
    return vessel(name, outside, 0.0022, bottom=0.092)


def carafe(name: str) -> bpy.types.Mesh:
    """A glass carafe, 0.24 m tall."""
    outside = [
        (0.0, 0.0),
        (0.050, 0.0),
        (0.068, 0.010),
        (0.078, 0.045),
        (0.066, 0.090),
        (0.032, 0.135),
        (0.025, 0.180),
        (0.037, 0.236),
    ]
    return vessel(name, outside, 0.004, bottom=0.012)


def vase(name: str, height: float = 0.3) -> bpy.types.Mesh:
    """A slender vase."""
    h = height
    outside = [
        (0.0, 0.0),
        (0.15 * h, 0.0),
        (0.2 * h, 0.1 * h),
        (0.27 * h, 0.4 * h),
        (0.2 * h, 0.72 * h),
        (0.11 * h, 0.88 * h),
        (0.15 * h, h),
    ]
    return vessel(name, outside, 0.02 * h)


def add_table(
    name: str,
    top: tuple[float, float],
    height: float,
    material: bpy.types.Material,
    location: Point,
    turn: float = 0.0,
    thickness: float = 0.035,
    leg: float = 0.05,
) -> bpy.types.Object:
    """A plain four-legged table with rounded edges."""
    x, y = top[0] / 2, top[1] / 2
    under = height - thickness
    inset = 0.04
    bounds: list[tuple[Point, Point]] = [((-x, -y, under), (x, y, height))]
    for sx in (-1, 1):
        for sy in (-1, 1):
            a, b = sx * (x - inset), sy * (y - inset)
            c, d = a - sx * leg, b - sy * leg
            low = (min(a, c), min(b, d), 0.0)
            bounds.append((low, (low[0] + leg, low[1] + leg, under - 0.0005)))
    rail = 0.02
    for sy in (-1, 1):
        edge = sy * (y - inset - leg / 2)
        bounds.append(
            (
                (-x + inset + leg + 0.0005, edge - rail / 2, under - 0.08),
                (x - inset - leg - 0.0005, edge + rail / 2, under - 0.0005),
            )
        )
    item = add_object(name, boxes(name, bounds), material, location=location, rotation=(0, 0, turn))
    return add_bevel(item, 0.004)


def add_framed_picture(
    name: str,
    size: tuple[float, float],
    picture: bpy.types.Material,
    frame: bpy.types.Material,
    location: Point,
    rotation: Point = (0, 0, 0),
    border: float = 0.03,
) -> None:
    """A picture in a frame in the local XZ plane, facing -Y, its back on y = 0."""
    x, z = size[0] / 2, size[1] / 2
    b, depth = border, 0.025
    bars = [
        ((-x - b, -depth, -z - b), (-x, 0, z + b)),
        ((x, -depth, -z - b), (x + b, 0, z + b)),
        ((-x + 0.0002, -depth, -z - b), (x - 0.0002, 0, -z)),
        ((-x + 0.0002, -depth, z), (x - 0.0002, 0, z + b)),
    ]
    bars_object = add_object(
        name + " frame", boxes(name + " frame", bars), frame, location=location, rotation=rotation
    )
    add_bevel(bars_object, 0.003)
    sheet = polygons(
        name,
        [(-x, -0.01, -z), (x, -0.01, -z), (x, -0.01, z), (-x, -0.01, z)],
        [(0, 1, 2, 3)],
        uvs=[(0, 0), (1, 0), (1, 1), (0, 1)],
    )
    add_object(name, sheet, picture, location=location, rotation=rotation)


def add_armchair(
    location: Point,
    turn: float,
    cloth: bpy.types.Material,
    legs: bpy.types.Material,
    velvet: bpy.types.Material,
) -> None:
    """Rounded cushions on turned legs with a pillow of `velvet`; it faces -Y."""
    root = bpy.data.objects.new("Armchair", None)
    bpy.context.scene.collection.objects.link(root)
    root.location, root.rotation_euler[2] = location, math.radians(turn)
    parts = [
        ((0.66, 0.64, 0.2), (0, 0, 0.24), 0),
        ((0.62, 0.2, 0.62), (0, 0.3, 0.34), -12),
        ((0.15, 0.68, 0.34), (-0.38, 0.0, 0.24), 0),
        ((0.15, 0.68, 0.34), (0.38, 0, 0.24), 0),
        ((0.58, 0.56, 0.13), (0, -0.03, 0.43), 0),
    ]
    for number, (size, place, tilt) in enumerate(parts):
        item = add_object(
            f"Cushion {number}", box("Cushion", size), cloth, location=place, rotation=(tilt, 0, 0)
        )
        add_bevel(item, 0.05, 3)
        item.data.polygons.foreach_set("use_smooth", [True] * 6)
        item.parent = root
    for x in (-0.34, 0.34):
        for y in (-0.26, 0.28):
            leg = lathe("Leg", [(0.0, 0.0), (0.013, 0.0), (0.024, 0.245), (0.0, 0.245)], 20)
            add_object("Leg", leg, legs, location=(x, y, 0.0)).parent = root
    pillow_mesh = box("Pillow", (0.38, 0.12, 0.36), on_floor=False)
    pillow = add_subdivision(
        add_object("Pillow", pillow_mesh, velvet, location=(0.08, 0.1, 0.73), rotation=(-22, 8, 6)),
        3,
    )
    pillow_mesh.polygons.foreach_set("use_smooth", [True] * 6)
    pillow.parent = root


def room_bounds(low: Point, high: Point, wall: float) -> list[tuple[Point, Point]]:
    """Six slabs of thickness `wall` around the inner box; for `boxes`."""
    (x0, y0, z0), (x1, y1, z1), w = low, high, wall
    return [
        ((x0 - w, y0 - w, z0 - w), (x1 + w, y1 + w, z0)),
        ((x0 - w, y0 - w, z1), (x1 + w, y1 + w, z1 + w)),
        ((x0 - w, y0 - w, z0), (x0, y1 + w, z1)),
        ((x1, y0 - w, z0), (x1 + w, y1 + w, z1)),
        ((x0, y0 - w, z0), (x1, y0, z1)),
        ((x0, y1, z0), (x1, y1 + w, z1)),
    ]


def circle(radius: float, z: float, count: int) -> list[Vector]:
    """Points on a horizontal circle."""
    return [
        Vector(
            (
                radius * math.cos(2 * math.pi * i / count),
                radius * math.sin(2 * math.pi * i / count),
                z,
            )
        )
        for i in range(count)
    ]
