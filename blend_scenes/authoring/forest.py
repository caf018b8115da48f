"""A clearing in a forest: a few heavy trees, placed hundreds of times."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

from .common import (
    SceneInfo,
    add_camera,
    add_collection_instance,
    add_light,
    add_object,
    add_subdivision,
    new_collection,
    new_scene,
    save_scene,
    set_world,
)
from .materials import new_material
from .shapes import ball, grid, polygons, spline, tube
from .surfaces import wood

INFO = SceneInfo(
    name="forest",
    purpose="A forest of about two million triangles, all by instances of six plants: ray "
    "traversal of instances decides the speed.",
    resolution=(480, 320),
    exposure=0.5,
)

_PATH_HALF_WIDTH = 1.5


def _ground_height(x: float, y: float) -> float:
    """The forest floor: soft humps, sunken along the winding path."""
    humps = 0.35 * math.sin(0.31 * x + 0.4) * math.cos(0.23 * y) + 0.12 * math.sin(0.9 * x + y)
    away = min(1.0, abs(x - _path_centre(y)) / 4.0)
    return humps * away + 0.25 * away


def _path_centre(y: float) -> float:
    """The x of the path's middle."""
    return 1.6 * math.sin(0.16 * y + 0.3)


def _foliage(
    name: str, low: tuple[float, float, float], high: tuple[float, float, float]
) -> bpy.types.Material:
    """Leaves that let light through, of a tone that differs from place to place."""
    material, nodes = new_material(name)
    noise = nodes.add(
        "TexNoise", {"Vector": nodes.coordinates("Object"), "Scale": 0.9, "Detail": 2.0}
    )
    color = nodes.ramp(noise.outputs["Fac"], [(0.35, low), (0.65, high)])
    skin = nodes.add("BsdfDiffuse", {"Color": color})
    through = nodes.add("BsdfTranslucent", {"Color": nodes.mix(0.5, color, (0.25, 0.32, 0.03))})
    nodes.output(
        nodes.add("MixShader", {0: 0.35, 1: skin.outputs[0], 2: through.outputs[0]}).outputs[0]
    )
    return material


class _Leaves:
    """Collects leaf quads; each is a lozenge bent along its middle."""

    def __init__(self) -> None:
        self.vertices: list[Vector] = []
        self.faces: list[tuple[int, ...]] = []

    def add(self, base: Vector, along: Vector, across: Vector) -> None:
        """Adds one leaf from `base` along `along`, `across` wide."""
        first = len(self.vertices)
        middle = base + 0.55 * along
        self.vertices += [base, middle - across / 2, base + along, middle + across / 2]
        self.faces.append((first, first + 1, first + 2, first + 3))

    def mesh(self, name: str) -> bpy.types.Mesh:
        """Returns the mesh of all leaves."""
        return polygons(name, self.vertices, self.faces, smooth=True)


def _conifer(
    name: str,
    height: float,
    whorls: int,
    seed: int,
    bark: bpy.types.Material,
    needles: bpy.types.Material,
) -> bpy.types.Collection:
    """A spruce: whorls of drooping branches, each a frond of sprigs."""
    generator = np.random.default_rng(seed)
    collection = new_collection(name, hidden=True)
    stem = [
        (
            0.03 * generator.standard_normal() * i,
            0.03 * generator.standard_normal() * i,
            height * i / 8,
        )
        for i in range(9)
    ]
    stem[0] = (0.0, 0.0, -0.4)
    trunk = tube(
        f"{name} trunk", stem, [0.021 * height * max(0.04, 1 - i / 7.2) for i in range(9)], 8
    )
    add_subdivision(add_object(f"{name} trunk", trunk, bark, collection=collection), 1)
    leaves = _Leaves()
    for whorl in range(whorls):
        rise = 0.12 + 0.85 * ((whorl + 0.5) / whorls) ** 0.85
        reach = height * (0.25 * (1.0 - rise) ** 0.75 + 0.02)
        branches = max(4, round(7.5 * (1.1 - rise)))
        turn = generator.uniform(0, 2 * math.pi)
        for branch in range(branches):
            angle = turn + 2 * math.pi * branch / branches + 0.2 * generator.standard_normal()
            out = Vector((math.cos(angle), math.sin(angle), 0.0))
            side = Vector((-out.y, out.x, 0.0))
            length = reach * generator.uniform(0.8, 1.15)
            sprigs = max(3, round(length / (0.03 * height)))
            for k in range(sprigs):
                t = (k + 0.6) / sprigs
                base = out * (length * t) + Vector((0, 0, rise * height - 0.45 * length * t * t))
                size = min(length, 0.15 * height) * (0.5 - 0.28 * t)
                drop = Vector((0, 0, -0.28 * size))
                for hand in (-1, 1):
                    leaves.add(
                        base,
                        (out * 0.75 + side * hand) * size + drop,
                        (out - side * hand * 0.6) * size * 0.42,
                    )
            leaves.add(
                out * (0.85 * length) + Vector((0, 0, rise * height - 0.33 * length)),
                out * 0.3 * length + Vector((0, 0, -0.12 * length)),
                side * 0.12 * length,
            )
    leaves.add(
        Vector((0, 0, 0.94 * height)), Vector((0, 0, 0.1 * height)), Vector((0.05 * height, 0, 0))
    )
    add_subdivision(
        add_object(
            f"{name} needles", leaves.mesh(f"{name} needles"), needles, collection=collection
        ),
        1,
    )
    return collection


def _broadleaf(
    name: str, height: float, seed: int, bark: bpy.types.Material, foliage: bpy.types.Material
) -> bpy.types.Collection:
    """A young beech: forked limbs with leaves strewn about their ends."""
    generator = np.random.default_rng(seed)
    collection = new_collection(name, hidden=True)
    fork = Vector((0.1, 0.05, 0.42 * height))
    limbs = [
        tube(
            f"{name} trunk",
            spline([(0, 0, -0.4), (0.05, -0.03, 0.2 * height), fork], 4),
            [0.024 * height] * 4 + [0.02 * height] * 5,
            8,
        )
    ]
    leaves = _Leaves()
    for limb in range(9):
        angle = 2.399963 * limb
        rise = generator.uniform(0.25, 0.6)
        tip = fork + Vector((math.cos(angle) * 0.26, math.sin(angle) * 0.26, rise)) * height * 0.9
        bend = fork.lerp(tip, 0.5) + Vector((0, 0, 0.04 * height))
        path = spline([fork - Vector((0, 0, 0.02 * height * limb / 3)), bend, tip], 4)
        limbs.append(
            tube(f"{name} limb", path, [0.012 * height * (1 - i / 10) for i in range(9)], 6)
        )
        for _ in range(100):
            along = generator.uniform(0.45, 1.05)
            centre = fork.lerp(tip, along)
            offset = Vector(generator.standard_normal(3)) * 0.075 * height
            out = (offset + Vector(generator.standard_normal(3)) * 0.04 * height).normalized()
            size = 0.052 * height * generator.uniform(0.7, 1.3)
            across = out.cross(Vector(generator.standard_normal(3))).normalized() * size * 0.6
            leaves.add(centre + offset, (out + Vector((0, 0, -0.3))) * size, across)
    for limb_mesh in limbs:
        add_object(limb_mesh.name, limb_mesh, bark, collection=collection)
    add_subdivision(
        add_object(f"{name} leaves", leaves.mesh(f"{name} leaves"), foliage, collection=collection),
        1,
    )
    return collection


def _fern(name: str, foliage: bpy.types.Material) -> bpy.types.Collection:
    """A fern: arching fronds of small leaves."""
    collection = new_collection(name, hidden=True)
    leaves = _Leaves()
    for frond in range(9):
        angle = 2.399963 * frond
        out = Vector((math.cos(angle), math.sin(angle), 0.0))
        side = Vector((-out.y, out.x, 0.0))
        for k in range(9):
            t = (k + 1) / 10
            base = out * (0.5 * t) + Vector((0, 0, 0.42 * t - 0.36 * t * t))
            size = 0.19 * math.sin(math.pi * min(1.0, 0.12 + 0.85 * t))
            for hand in (-1, 1):
                leaves.add(
                    base, (side * hand + out * 0.3) * size - Vector((0, 0, 0.03)), out * size * 0.4
                )
    add_subdivision(add_object(name, leaves.mesh(name), foliage, collection=collection), 1)
    return collection


def _ground() -> bpy.types.Material:
    material, nodes = new_material("Forest floor")
    place = nodes.coordinates("Object")
    patches = nodes.add("TexNoise", {"Vector": place, "Scale": 0.5, "Detail": 8.0})
    litter = nodes.add("TexNoise", {"Vector": place, "Scale": 14.0, "Detail": 5.0})
    moss = nodes.ramp(
        litter.outputs["Fac"], [(0.35, (0.03, 0.06, 0.012)), (0.65, (0.11, 0.16, 0.03))]
    )
    earth = nodes.ramp(
        litter.outputs["Fac"], [(0.35, (0.07, 0.045, 0.025)), (0.65, (0.24, 0.17, 0.1))]
    )
    factor = nodes.ramp(patches.outputs["Fac"], [(0.45, (0, 0, 0)), (0.6, (1, 1, 1))])
    bump = nodes.add("Bump", {"Height": litter.outputs["Fac"], "Strength": 0.8, "Distance": 0.05})
    nodes.output(
        nodes.add(
            "BsdfDiffuse", {"Color": nodes.mix(factor, earth, moss), "Normal": bump.outputs[0]}
        ).outputs[0]
    )
    return material


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    set_world(scene, (0.55, 0.72, 1.0), 1.1)
    bark = wood(
        "Bark", (0.035, 0.022, 0.015), (0.16, 0.11, 0.075), grain=(14.0, 14.0, 2.0), roughness=0.8
    )
    pale_bark = wood(
        "Beech bark", (0.14, 0.13, 0.11), (0.34, 0.31, 0.27), grain=(6.0, 6.0, 9.0), roughness=0.8
    )
    spruce = _foliage("Spruce", (0.012, 0.045, 0.018), (0.04, 0.1, 0.03))
    beech = _foliage("Beech", (0.06, 0.15, 0.015), (0.2, 0.3, 0.04))
    fern = _foliage("Fern", (0.05, 0.14, 0.02), (0.14, 0.26, 0.04))
    trees = [
        _conifer("Tall spruce", 13.0, 23, 1, bark, spruce),
        _conifer("Spruce", 9.5, 19, 2, bark, spruce),
        _conifer("Young spruce", 4.0, 13, 3, bark, spruce),
        _broadleaf("Beech", 9.0, 4, pale_bark, beech),
        _broadleaf("Young beech", 5.0, 5, pale_bark, beech),
    ]
    fern_plant = _fern("Fern", fern)
    add_object(
        "Ground",
        grid("Ground", (90.0, 90.0), (90, 90), lambda x, y: _ground_height(x, y + 30.0)),
        _ground(),
        location=(0, 30, 0),
    )
    generator = np.random.default_rng(42)
    plants = new_collection("Plants")
    placed: list[tuple[float, float]] = []
    chances = (0.3, 0.27, 0.1, 0.21, 0.12)
    while len(placed) < 180:
        x, y = generator.uniform(-26, 26), generator.uniform(-6, 58)
        clear = _PATH_HALF_WIDTH + 0.9 if y > 3 else 3.4
        near = any((x - a) ** 2 + (y - b) ** 2 < 2.4 for a, b in placed)
        if abs(x - _path_centre(y)) < clear or near or (y < 1.5 and abs(x) < 5.0):
            continue
        placed.append((x, y))
        add_collection_instance(
            "Tree",
            trees[generator.choice(5, p=chances)],
            (x, y, _ground_height(x, y)),
            generator.uniform(0, 360),
            generator.uniform(0.75, 1.2),
            plants,
        )
    ferns = 0
    while ferns < 300:
        x, y = generator.uniform(-9, 9), generator.uniform(-1.0, 22)
        if abs(x - _path_centre(y)) < 1.0 + 0.3 * generator.random():
            continue
        ferns += 1
        add_collection_instance(
            "Fern",
            fern_plant,
            (x, y, _ground_height(x, y) - 0.02),
            generator.uniform(0, 360),
            generator.uniform(0.7, 1.6),
            plants,
        )
    stone = ball("Stone", 0.4, 12, 8)
    stone.transform(Matrix.Diagonal((1.2, 0.9, 0.7, 1.0)))
    rock = wood(
        "Stone", (0.12, 0.12, 0.11), (0.3, 0.29, 0.27), grain=(5.0, 5.0, 5.0), roughness=0.9
    )
    stone.materials.append(rock)
    for i in range(14):
        y = generator.uniform(-1, 18)
        x = _path_centre(y) + (1.35 + 0.5 * generator.random()) * (1 if i % 2 else -1)
        add_subdivision(
            add_object(
                "Stone",
                stone,
                location=(x, y, _ground_height(x, y) + 0.05),
                scale=generator.uniform(0.4, 1.2),
                rotation=(0, 0, generator.uniform(0, 360)),
            ),
            1,
        )
    sun = add_light("Sun", "SUN", 17.0, (1.0, 0.84, 0.62), (-16.0, 3.0, 15.0), (0, 0, 0))
    sun.data.angle = math.radians(1.0)
    add_camera(
        scene, (_path_centre(-5.0) + 0.2, -5.0, 1.6), (_path_centre(8.0), 8.0, 2.4), lens=26.0
    )
    save_scene(scene, path)
