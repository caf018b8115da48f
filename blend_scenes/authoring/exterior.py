"""A small pavilion under a painted sky, which is the only light."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np

from .common import SceneInfo, add_bevel, add_camera, add_object, new_scene, save_scene
from .images import Array, packed_radiance, value_noise
from .materials import Nodes, glass, metal, new_material, principled
from .shapes import ball, box, boxes, grid, tube
from .surfaces import concrete, wood

INFO = SceneInfo(
    name="exterior",
    purpose="An exterior under a high-dynamic-range environment image with a bright sun: "
    "importance sampling of an environment, hard shadows and sky reflections.",
    resolution=(512, 320),
    exposure=-1.0,
)

# The sun's azimuth (from +X towards +Y), elevation and angular radius, in degrees.
_SUN = (-142.0, 36.0, 1.2)


def sky(width: int) -> Array:
    """Linear radiance of sky, clouds, sun and a grey-green ground, `width` x `width / 2`.

    Column u looks to azimuth 2 pi (0.5 - u), row v to elevation pi (v - 0.5), as Blender has it.
    """
    height = width // 2
    v, u = np.mgrid[0:height, 0:width]
    azimuth = 2 * math.pi * (0.5 - (u + 0.5) / width)
    elevation = math.pi * ((v + 0.5) / height - 0.5)
    direction = np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ],
        axis=-1,
    )
    turn, rise, radius = (math.radians(angle) for angle in _SUN)
    to_sun = np.array(
        [math.cos(rise) * math.cos(turn), math.cos(rise) * math.sin(turn), math.sin(rise)]
    )
    cosine = direction @ to_sun
    up = np.clip(direction[..., 2], 0.0, 1.0)[..., None]
    zenith, horizon = np.array([0.13, 0.32, 0.8]), np.array([0.75, 0.82, 0.9])
    radiance = horizon + (zenith - horizon) * up**0.45
    radiance += np.array([1.0, 0.75, 0.45]) * (
        0.5 * np.clip(cosine, 0, 1)[..., None] ** 24 + 3.0 * np.clip(cosine, 0, 1)[..., None] ** 900
    )
    noise = value_noise(width, 12, 21, 5)
    # Clouds are drawn in perspective on a plane overhead.
    reach = 90.0 / (up[..., 0] + 0.13)
    x = (reach * direction[..., 0]).astype(int) % width
    y = (reach * direction[..., 1] * 1.6).astype(int) % width
    cover = np.clip((noise[y, x] - 0.48) * 5.0, 0, 1) * np.clip(up[..., 0] * 5 - 0.2, 0, 1)
    radiance += (np.array([1.25, 1.2, 1.15]) - radiance) * (0.85 * cover)[..., None]
    below = direction[..., 2] < 0
    radiance[below] = np.array([0.2, 0.2, 0.17])
    disc = np.clip((np.arccos(np.clip(cosine, -1, 1)) - radius) / (-0.25 * radius), 0, 1)
    return np.asarray(radiance + disc[..., None] * np.array([17000.0, 14000.0, 10500.0]))


def _set_sky(scene: bpy.types.Scene) -> None:
    world = scene.world
    world.node_tree.nodes.clear()
    nodes = Nodes(world.node_tree)
    picture = nodes.add("TexEnvironment", image=packed_radiance("sky", sky(1024)))
    background = nodes.add("Background", {"Color": picture.outputs["Color"], "Strength": 1.0})
    nodes.add("OutputWorld", {"Surface": background.outputs[0]})


def _leaves() -> bpy.types.Material:
    material, nodes = new_material("Clipped box")
    noise = nodes.add(
        "TexNoise", {"Vector": nodes.coordinates("Object"), "Scale": 24.0, "Detail": 4.0}
    )
    color = nodes.ramp(
        noise.outputs["Fac"], [(0.35, (0.015, 0.05, 0.012)), (0.7, (0.11, 0.2, 0.04))]
    )
    bump = nodes.add("Bump", {"Height": noise.outputs["Fac"], "Strength": 1.0, "Distance": 0.05})
    nodes.output(
        nodes.add(
            "BsdfPrincipled", {"Base Color": color, "Roughness": 0.6, "Normal": bump.outputs[0]}
        ).outputs[0]
    )
    return material


def _lawn() -> bpy.types.Material:
    material, nodes = new_material("Lawn")
    noise = nodes.add(
        "TexNoise", {"Vector": nodes.coordinates("Object"), "Scale": 6.0, "Detail": 8.0}
    )
    color = nodes.ramp(noise.outputs["Fac"], [(0.3, (0.05, 0.1, 0.02)), (0.7, (0.16, 0.23, 0.06))])
    nodes.output(nodes.add("BsdfDiffuse", {"Color": color}).outputs[0])
    return material


def _add_pavilion() -> None:
    """A slab on slender columns over a terrace, with a wall of wood and one of glass."""
    cast = concrete("Concrete", (0.62, 0.6, 0.56))
    terrace = [((-1.2, 0.0, 0.0), (6.4, 5.2, 0.3)), ((-2.0, 0.6, 0.0), (-1.205, 4.4, 0.15))]
    add_bevel(add_object("Terrace", boxes("Terrace", terrace), cast), 0.01)
    roof = [((-1.7, -0.5, 3.05), (6.9, 5.7, 3.3))]
    add_bevel(
        add_object("Roof", boxes("Roof", roof), principled("Render", (0.8, 0.79, 0.76), 0.7)), 0.01
    )
    steel = metal("Steel", (0.62, 0.62, 0.64), 0.25)
    columns = [
        ((x, y, 0.3), (x + 0.1, y + 0.1, 3.05)) for x in (-0.9, 2.5, 5.9) for y in (0.3, 4.7)
    ]
    add_bevel(add_object("Columns", boxes("Columns", columns), steel), 0.006)
    cedar = wood("Cedar", (0.16, 0.07, 0.03), (0.45, 0.22, 0.1), grain=(12.0, 12.0, 0.9))
    slats = [((0.9 + 0.11 * i, 3.6, 0.3), (0.9 + 0.11 * i + 0.095, 3.68, 3.05)) for i in range(36)]
    add_object("Cedar wall", boxes("Cedar wall", slats), cedar)
    pane = [((2.56, 0.85, 0.32), (2.572, 3.5, 3.04))]
    add_object("Glass wall", boxes("Glass wall", pane), glass("Window glass", 1.5))
    bench = [
        ((0.6, 2.6, 0.68), (2.2, 3.05, 0.75)),
        ((0.7, 2.65, 0.3), (0.78, 3.0, 0.679)),
        ((2.02, 2.65, 0.3), (2.1, 3.0, 0.679)),
    ]
    add_bevel(add_object("Bench", boxes("Bench", bench), cedar), 0.006)


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    _set_sky(scene)
    add_object("Lawn", grid("Lawn", (160.0, 160.0), (2, 2)), _lawn(), location=(0, 40, -0.02))
    paving = concrete("Paving", (0.52, 0.48, 0.42))
    slabs = [
        (
            (-5.4 + 1.2 * i, -4.8 + 1.2 * j, -0.06),
            (-5.4 + 1.2 * i + 1.185, -4.8 + 1.2 * j + 1.185, 0.0),
        )
        for i in range(11)
        for j in range(4)
    ]
    add_bevel(add_object("Paving", boxes("Paving", slabs), paving), 0.008)
    _add_pavilion()
    bronze = metal("Bronze", (0.82, 0.53, 0.28), 0.13)
    knot = []
    for i in range(240):
        t = 2 * math.pi * i / 240
        reach = 0.55 + 0.24 * math.cos(3 * t)
        knot.append((reach * math.cos(2 * t), 0.3 * math.sin(3 * t) + 0.0, reach * math.sin(2 * t)))
    add_object(
        "Sculpture",
        tube("Sculpture", knot, 0.11, 24, loop=True),
        bronze,
        location=(-2.6, -1.3, 1.75),
        rotation=(0, 0, 25),
    )
    add_bevel(
        add_object(
            "Plinth",
            box("Plinth", (0.8, 0.8, 0.82)),
            principled("Plinth", (0.75, 0.73, 0.7), 0.5),
            location=(-2.6, -1.3, 0.0),
            rotation=(0, 0, 12),
        ),
        0.01,
    )
    add_object(
        "Mirror ball",
        ball("Mirror ball", 0.42, 64, 32),
        metal("Chrome", (0.95,) * 3, 0.0),
        location=(0.35, -1.6, 0.42),
    )
    leaves = _leaves()
    shape = ball("Box bush", 1.0, 48, 24)
    for i, (x, y, size) in enumerate(
        (
            (-4.2, 1.3, 0.75),
            (-3.2, 2.2, 0.55),
            (-5.4, 2.6, 0.95),
            (4.1, -0.7, 0.42),
            (5.0, -0.75, 0.5),
            (3.3, -0.65, 0.34),
        )
    ):
        add_object(f"Box bush {i}", shape, leaves, location=(x, y, size * 0.8), scale=size)
    cone = ball("Cypress", 1.0, 48, 24)
    generator = np.random.default_rng(8)
    for i in range(9):
        tall = 3.2 + 1.6 * generator.random()
        add_object(
            f"Cypress {i}",
            cone,
            leaves,
            location=(-9.0 + 2.3 * i, 9.5 + generator.random(), tall * 0.9),
            scale=(0.6, 0.6, tall),
        )
    add_camera(scene, (-3.6, -8.2, 1.55), (0.3, 0.6, 1.5), lens=30.0)
    save_scene(scene, path)
