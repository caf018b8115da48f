"""Procedural surfaces: wood, plaster, stone. Each an ordinary tree of noise, ramps and bump."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from .materials import new_material

Color = Sequence[float]


def wood(
    name: str,
    dark: Color,
    light: Color,
    *,
    grain: Sequence[float] = (1.2, 22.0, 22.0),
    roughness: float = 0.4,
    coat: float = 0.0,
) -> bpy.types.Material:
    """Wood whose grain runs along the axis of least `grain` (frequencies per metre)."""
    material, nodes = new_material(name)
    place = nodes.coordinates("Object", grain)
    noise = nodes.add(
        "TexNoise",
        {"Vector": place, "Scale": 1.0, "Detail": 5.0, "Roughness": 0.6, "Distortion": 0.6},
    )
    color = nodes.ramp(noise.outputs["Fac"], [(0.3, dark), (0.7, light)])
    rough = nodes.math("MULTIPLY_ADD", noise.outputs["Fac"], 0.25)
    rough.node.inputs[2].default_value = roughness - 0.12
    bump = nodes.add("Bump", {"Height": noise.outputs["Fac"], "Strength": 0.15, "Distance": 0.01})
    shader = nodes.add(
        "BsdfPrincipled",
        {
            "Base Color": color,
            "Roughness": rough,
            "Normal": bump.outputs["Normal"],
            "Coat Weight": coat,
            "Coat Roughness": 0.08,
        },
    )
    nodes.output(shader.outputs[0])
    return material


def plaster(
    name: str, color: Color, scale: float = 40.0, strength: float = 0.1
) -> bpy.types.Material:
    """A matte wall with a faint unevenness; `scale` is in lumps per metre."""
    material, nodes = new_material(name)
    place = nodes.coordinates("Object")
    noise = nodes.add("TexNoise", {"Vector": place, "Scale": scale, "Detail": 3.0})
    bump = nodes.add(
        "Bump", {"Height": noise.outputs["Fac"], "Strength": strength, "Distance": 0.01}
    )
    shade = nodes.mix(nodes.math("MULTIPLY", noise.outputs["Fac"], 0.12), color, (0, 0, 0))
    nodes.output(
        nodes.add("BsdfDiffuse", {"Color": shade, "Normal": bump.outputs["Normal"]}).outputs[0]
    )
    return material


def concrete(name: str, color: Color, roughness: float = 0.7) -> bpy.types.Material:
    """Cast concrete: two scales of stains and a fine bump."""
    material, nodes = new_material(name)
    place = nodes.coordinates("Object")
    stains = nodes.add("TexNoise", {"Vector": place, "Scale": 0.9, "Detail": 6.0})
    grains = nodes.add("TexNoise", {"Vector": place, "Scale": 30.0, "Detail": 4.0})
    tone = nodes.ramp(stains.outputs["Fac"], [(0.3, [0.72 * c for c in color]), (0.75, color)])
    fine = nodes.ramp(grains.outputs["Fac"], [(0.35, (0.8, 0.8, 0.8)), (0.6, (1, 1, 1))])
    bump = nodes.add("Bump", {"Height": grains.outputs["Fac"], "Strength": 0.2, "Distance": 0.01})
    shader = nodes.add(
        "BsdfPrincipled",
        {
            "Base Color": nodes.mix(1.0, tone, fine, "MULTIPLY"),
            "Roughness": roughness,
            "Normal": bump.outputs["Normal"],
        },
    )
    nodes.output(shader.outputs[0])
    return material


def marble(
    name: str, ground: Color, vein: Color, scale: float = 3.0, roughness: float = 0.12
) -> bpy.types.Material:
    """Polished marble: veins where a distorted noise crosses its middle."""
    material, nodes = new_material(name)
    place = nodes.coordinates("Object")
    noise = nodes.add(
        "TexNoise", {"Vector": place, "Scale": scale, "Detail": 7.0, "Distortion": 1.4}
    )
    veins = nodes.math("ABSOLUTE", nodes.math("SUBTRACT", noise.outputs["Fac"], 0.5))
    color = nodes.ramp(
        veins,
        [
            (0.0, vein),
            (0.035, [0.5 * (a + b) for a, b in zip(ground, vein, strict=True)]),
            (0.11, ground),
        ],
    )
    shader = nodes.add("BsdfPrincipled", {"Base Color": color, "Roughness": roughness})
    nodes.output(shader.outputs[0])
    return material
