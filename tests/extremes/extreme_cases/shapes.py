"""Geometry that is nearly or wholly degenerate: the picture is that of the plain shape."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from bidirectional_scenes import GREY, lamp, room
from engine_core.description import Mesh
from scenes import Array, SceneBuilder, box, diffuse, mesh, placed, quad, sphere

from extreme_cases.case import Case, Finite, Same, power_of_ten

Change = Callable[[SceneBuilder], None]

SETTINGS = {"max_bounces": 4}


def scene(change: Change | None = None) -> SceneBuilder:
    built = room()
    lamp("AREA", built, size_x=0.8, size_y=0.5)
    if change is not None:
        change(built)
    return built


def floor(shape: Mesh, built: SceneBuilder) -> None:
    """Another mesh in place of the floor."""
    built.description.meshes[0] = shape


def needles(count: int) -> Mesh:
    """The floor as a fan of thin triangles from a corner."""
    t = np.linspace(-2, 2, count + 1)
    rim = [(2.0, y, 0.0) for y in t] + [(x, 2.0, 0.0) for x in t[::-1][1:]]
    faces = [(0, i, i + 1) for i in range(1, len(rim))]
    return mesh("needles", [(-2.0, -2.0, 0.0), *rim], faces)


def with_empty_faces(shape: Mesh) -> Mesh:
    """Triangles without area between those of the floor: a point thrice, and three on a line."""
    positions = np.concatenate([shape.positions, [[0, 0, 0], [-1, 0, 0], [1, 0, 0]]])
    return mesh("empty", positions, [(0, 1, 2, 3), (4, 4, 4), (4, 5, 6), (0, 0, 1), (6, 5, 4)])


def turned(shape: Mesh) -> None:
    """Its faces wound the other way."""
    shape.corner_vertices = shape.corner_vertices[::-1].copy()
    shape.face_offsets = (shape.face_offsets[-1] - shape.face_offsets[::-1]).astype(np.int32)


def flipped(built: SceneBuilder) -> None:
    """All faces inside out."""
    for shape in built.description.meshes:
        turned(shape)
        if shape.normals is not None:
            shape.normals = -shape.normals


def twice(gap: float, built: SceneBuilder) -> None:
    """Every face of the room twice, `gap` apart."""
    d = built.description
    for index in range(len(d.instances.mesh)):
        rows = d.instances.transform[index].copy()
        rows[:, 3] -= gap
        material = d.material_sets[d.instances.material_set[index]][0]
        built.instance(int(d.instances.mesh[index]), material, transform=rows)


def stack(count: int, gap: float, built: SceneBuilder) -> None:
    """Sheets below the floor."""
    for i in range(1, count + 1):
        built.add(quad((-2, -2, -gap * i), (4, 0, 0), (0, 4, 0)), diffuse((0.7, 0.6, 0.5)))


def stretched(scale: Array, built: SceneBuilder) -> None:
    """Objects whose matrix undoes what was done to their vertices."""
    d = built.description
    for shape in d.meshes:
        if np.prod(scale) < 0:
            turned(shape)
        shape.positions = (shape.positions / scale).astype(np.float32)
        if shape.normals is not None:
            normals = shape.normals * scale
            shape.normals = (normals / np.linalg.norm(normals, axis=1)[:, None]).astype(np.float32)
    d.instances.transform[:, :, :3] = np.diag(scale).astype(np.float32)


def instanced(built: SceneBuilder) -> None:
    """Another of each, out of sight: those that stay are traversed in their own space."""
    d = built.description
    for index in range(len(d.instances.mesh)):
        rows = d.instances.transform[index].copy()
        rows[:, 3] += (500.0, 500.0, -500.0)
        built.instance(int(d.instances.mesh[index]), transform=rows)


def both(first: Change, second: Change, built: SceneBuilder) -> None:
    first(built)
    second(built)


def under(rows: Array, built: SceneBuilder) -> None:
    """A ball and a box under any matrix."""
    material = built.material(diffuse(GREY))
    for shape in (sphere(0.5, rings=6), box((0, 0, 0), (1, 1, 1))):
        index = built.mesh(shape)
        for x in (0.0, 0.5):
            built.instance(index, material, transform=placed(rows, (x, 0, 1)))


SINGULAR = {
    "zero": np.zeros((3, 3)),
    "flat": np.diag([1.0, 1.0, 0.0]),
    "a line": np.diag([0.0, 0.0, 1.0]),
    "rank one": np.ones((3, 3)),
    "rank two": np.array([[1.0, 2, 3], [2, 4, 6], [0, 1, 0]]),
    "nearly flat": np.diag([1.0, 1.0, 1e-30]),
    "1e30 by 1e-30": np.diag([1e30, 1.0, 1e-30]),
    "sheared by 1e6": np.array([[1.0, 1e6, 0], [0, 1, 0], [0, 0, 1]]),
}


def cases() -> list[Case]:
    changes: dict[str, tuple[Change, float]] = {
        "floor of 200 needles": (partial(floor, needles(100)), 0.0),
        "floor of 20,000 needles": (partial(floor, needles(10000)), 0.0),
        "faces without area": (
            partial(floor, with_empty_faces(quad((-2, -2, 0), (4, 0, 0), (0, 4, 0)))), 0.0),
        "inside out": (flipped, 0.0),
        "coincident faces": (partial(twice, 0.0), 0.0),
    }  # fmt: skip
    for gap in (1e-7, 1e-6, 1e-5, 1e-4):
        changes[f"all twice, {power_of_ten(gap)} apart"] = (partial(twice, gap), 1e-3)
        changes[f"100 sheets, {power_of_ten(gap)} apart"] = (partial(stack, 100, gap), 0.0)
    for scale in ((1e3, 1, 1e-3), (1e-6, 1, 1e6), (1e-6,) * 3, (1e6,) * 3, (1, 1e-4, 1)):
        text = " by ".join(power_of_ten(s) for s in scale)
        change = partial(stretched, np.array(scale, np.float64))
        changes[f"stretched by {text}"] = (change, 0.0)
        changes[f"instances stretched by {text}"] = (partial(both, change, instanced), 0.0)
    for scale in ((-1, 1, 1), (1, -1, 1), (-1, -1, -1)):
        change = partial(stretched, np.array(scale, np.float64))
        text = " by ".join(str(s) for s in scale)
        changes[f"mirrored {text}"] = (change, 0.0)
        changes[f"instances mirrored {text}"] = (partial(both, change, instanced), 0.0)
    found = [
        Case("shapes", name, partial(scene, change), Same(scene, slack=slack), settings=SETTINGS)
        for name, (change, slack) in changes.items()
    ]
    for name, rows in SINGULAR.items():
        found.append(
            Case("shapes", f"matrix {name}", partial(scene, partial(under, rows)), Finite(),
                 settings=SETTINGS)
        )  # fmt: skip
    return found
