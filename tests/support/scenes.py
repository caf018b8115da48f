"""Scenes made by hand, without Blender, and their renders as arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from engine_core.description import (
    Camera,
    Domain,
    Film,
    Graph,
    InputValue,
    Light,
    Link,
    Material,
    Mesh,
    Node,
    Object,
    SceneDescription,
    Visibility,
    World,
)
from numpy.typing import NDArray

import engine_core

Array = NDArray[np.float64]
Vector = Sequence[float]


def shader(kind: str, **inputs: InputValue) -> Graph:
    """A graph of one shader node; underscores in names of inputs stand for blanks."""
    output = {"ShaderNodeEmission": "Emission", "ShaderNodeBackground": "Background"}.get(
        kind, "BSDF"
    )
    sockets = {name.replace("_", " "): value for name, value in inputs.items()}
    return Graph([Node(kind, inputs=sockets)], Link(0, output))


def rgba(color: float | Vector) -> tuple[float, float, float, float]:
    """An RGBA tuple from a grey or an RGB colour."""
    r, g, b = (color, color, color) if isinstance(color, int | float) else color
    return (r, g, b, 1.0)


def diffuse(color: float | Vector) -> Graph:
    return shader("ShaderNodeBsdfDiffuse", Color=rgba(color))


def emission(strength: float, color: float | Vector = 1.0) -> Graph:
    return shader("ShaderNodeEmission", Color=rgba(color), Strength=strength)


def background(strength: float, color: float | Vector = 1.0) -> World:
    return World(shader("ShaderNodeBackground", Color=rgba(color), Strength=strength))


def mesh(name: str, positions: object, faces: Sequence[Sequence[int]]) -> Mesh:
    """A flat-shaded mesh of polygons."""
    offsets = np.cumsum([0, *(len(face) for face in faces)]).astype(np.int32)
    corners = np.array([v for face in faces for v in face], np.int32)
    return Mesh(name, np.ascontiguousarray(positions, np.float32), corners, offsets)


def quad(corner: Vector, edge_u: Vector, edge_v: Vector, name: str = "quad") -> Mesh:
    """A parallelogram whose front side is edge_u x edge_v."""
    p, u, v = (np.array(x, np.float64) for x in (corner, edge_u, edge_v))
    return mesh(name, np.stack([p, p + u, p + u + v, p + v]), [(0, 1, 2, 3)])


def box(low: Vector, high: Vector, inward: bool = False, name: str = "box") -> Mesh:
    """An axis-aligned box; normals outward, or inward for rooms."""
    a, b = np.array(low, np.float64), np.array(high, np.float64)
    corners = np.array([[(b if i >> k & 1 else a)[k] for k in range(3)] for i in range(8)])
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return mesh(name, corners, [f[::-1] for f in faces] if inward else faces)


def sphere(
    radius: float = 1.0,
    center: Vector = (0, 0, 0),
    rings: int = 64,
    smooth: bool = True,
    name: str = "sphere",
) -> Mesh:
    """A sphere of quads and polar triangles, with its true normals where it is smooth."""
    segments = 2 * rings
    theta = np.linspace(0.0, np.pi, rings + 1)[1:-1]
    phi = np.arange(segments) * (2.0 * np.pi / segments)
    body = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.outer(np.cos(theta), np.ones(segments)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    normals = np.concatenate([[[0.0, 0.0, 1.0]], body, [[0.0, 0.0, -1.0]]])
    last = len(normals) - 1
    faces: list[tuple[int, ...]] = []
    for s in range(segments):
        t = (s + 1) % segments
        faces.append((0, 1 + s, 1 + t))
        for r in range(rings - 2):
            a, b = 1 + r * segments, 1 + (r + 1) * segments
            faces.append((a + s, b + s, b + t, a + t))
        a = 1 + (rings - 2) * segments
        faces.append((a + s, last, a + t))
    result = mesh(name, normals * radius + np.array(center), faces)
    if smooth:
        result.normal_domain = Domain.POINT
        result.normals = normals.astype(np.float32)
    return result


def identity() -> NDArray[np.float32]:
    return np.eye(3, 4, dtype=np.float32)


def placed(linear: object = 1.0, at: Vector = (0, 0, 0)) -> NDArray[np.float32]:
    """Object-to-world rows: a scalar, diagonal or 3x3 linear part and a place."""
    part = np.array(linear, np.float64)
    matrix = np.eye(3) * part if part.ndim < 2 else part
    return np.concatenate([matrix, np.array(at, np.float64)[:, None]], axis=1).astype(np.float32)


def look_at(eye: Vector, target: Vector, up: Vector = (0, 0, 1)) -> NDArray[np.float32]:
    """The transform of a camera or lamp at `eye` that looks along -z at `target`."""
    e, t = np.array(eye, np.float64), np.array(target, np.float64)
    z = (e - t) / np.linalg.norm(e - t)
    x = np.cross(np.array(up, np.float64), z)
    if np.linalg.norm(x) < 1e-6:
        x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z, e], axis=1).astype(np.float32)


class SceneBuilder:
    """Collects the parts of a description."""

    def __init__(self, size: tuple[int, int] = (16, 16)) -> None:
        self.description = SceneDescription()
        self.description.film = Film(*size, crop=(0, 0, *size), filter="BOX", filter_width=1.0)
        self.camera((0, 0, 5), (0, 0, 0))

    def camera(self, eye: Vector, target: Vector, fov: float = 40.0, **fields: object) -> Camera:
        film = self.description.film
        half = np.tan(np.radians(fov) / 2)
        aspect = film.height / film.width
        camera = Camera(transform=look_at(eye, target))
        camera.window = (-half, half, -half * aspect, half * aspect)
        camera.clip_start, camera.clip_end = 1e-4, 1e6
        for name, value in fields.items():
            setattr(camera, name, value)
        self.description.camera = camera
        return camera

    def material(self, graph: Graph, name: str = "") -> int:
        materials = self.description.materials
        materials.append(Material(name or f"material {len(materials)}", graph))
        return len(materials) - 1

    def mesh(self, shape: Mesh) -> int:
        self.description.meshes.append(shape)
        return len(self.description.meshes) - 1

    def instance(
        self,
        shape: int,
        material: int = -1,
        transform: NDArray[np.float32] | None = None,
        visibility: int = Visibility.ALL,
    ) -> None:
        d = self.description
        i = d.instances
        d.material_sets.append([material])
        d.objects.append(Object(f"object {len(d.objects)}"))
        rows = identity() if transform is None else transform
        i.mesh = np.append(i.mesh, np.int32(shape))
        i.transform = np.concatenate([i.transform, rows[None].astype(np.float32)])
        i.visibility = np.append(i.visibility, np.uint32(visibility))
        i.material_set = np.append(i.material_set, np.int32(len(d.material_sets) - 1))
        i.random = np.append(i.random, np.float32(0.5))
        i.object = np.append(i.object, np.int32(len(d.objects) - 1))

    def add(self, shape: Mesh, graph: Graph | None = None, **fields: object) -> None:
        """A mesh with a material of its own."""
        material = -1 if graph is None else self.material(graph)
        self.instance(self.mesh(shape), material, **fields)  # type: ignore[arg-type]

    def light(self, kind: str, **fields: object) -> Light:
        light = Light(f"light {len(self.description.lights)}", kind)
        for name, value in fields.items():
            setattr(light, name, value)
        self.description.lights.append(light)
        return light


def soft_scene(size: int) -> SceneBuilder:
    """A ball under a panel and an even sky: light that every method finds soon."""
    scene = SceneBuilder((size, size))
    scene.camera((0, -5, 3), (0, 0, 0.3))
    scene.add(quad((-4, -4, 0), (8, 0, 0), (0, 8, 0)), diffuse(0.5))
    scene.add(sphere(0.8, (0, 0, 0.8), rings=12), diffuse((0.8, 0.4, 0.3)))
    scene.add(quad((-1, -1, 4), (0, 2, 0), (2, 0, 0)), emission(6.0))
    scene.description.world = background(0.2)
    return scene


def render(
    description: SceneDescription | SceneBuilder,
    passes: Sequence[str] = ("Combined",),
    **settings: object,
) -> dict[str, Array]:
    """Renders on two threads; passes by name, (height, width, channels), the top row last."""
    if isinstance(description, SceneBuilder):
        description = description.description
    scene = engine_core.compile(description, threads=2)
    session = engine_core.Session(scene, {"threads": 2, **settings}, list(passes))
    session.start()
    while not session.wait(10.0):
        pass
    assert not session.error_message
    assert session.poll().non_finite == 0
    return {
        name: np.asarray(session.read(name, 0, 0, scene.width, scene.height), np.float64)
        for name in passes
    }


def picture(description: SceneDescription | SceneBuilder, **settings: object) -> Array:
    """RGB of the picture alone."""
    return render(description, **settings)["Combined"][..., :3]


def pictures(description: SceneDescription | SceneBuilder, seeds: int, **settings: object) -> Array:
    """Independent pictures: (seeds, height, width, 3)."""
    return np.stack([picture(description, seed=seed, **settings) for seed in range(seeds)])
