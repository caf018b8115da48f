"""White furnace: a field of balls that absorb nothing, within a constant world of radiance 1."""

from __future__ import annotations

from pathlib import Path

import bpy

from .common import SceneInfo, add_camera, add_object, new_scene, save_scene, set_world
from .materials import closure, diffuse, glass, new_material, principled
from .shapes import ball

INFO = SceneInfo(
    name="furnace",
    purpose="White furnace: balls of many materials and roughnesses, none of which absorbs, in a "
    "constant world of radiance 1; all of them must vanish. The four grey balls, seen by the "
    "camera alone, must read 0.2, 0.4, 0.6 and 0.8.",
    resolution=(448, 320),
    bounces=1024,
    view_transform="Standard",
)

ROUGHNESS = (0.0, 0.1, 0.25, 0.5, 1.0)
GREYS = (0.2, 0.4, 0.6, 0.8)
_WHITE = (1.0, 1.0, 1.0)


def _half_transparent(roughness: float) -> bpy.types.Material:
    """Half transparent, half white gloss."""
    material, nodes = new_material(f"Half transparent {roughness}")
    hole = nodes.add("BsdfTransparent")
    gloss = nodes.add(
        "BsdfAnisotropic", {"Color": _WHITE, "Roughness": roughness}, distribution="MULTI_GGX"
    )
    nodes.output(
        nodes.add("MixShader", {0: 0.5, 1: hole.outputs[0], 2: gloss.outputs[0]}).outputs[0]
    )
    return material


def _glossy(roughness: float) -> bpy.types.Material:
    return closure(
        f"Glossy {roughness}",
        "BsdfAnisotropic",
        {"Color": _WHITE, "Roughness": roughness},
        distribution="MULTI_GGX",
    )


def _glass(roughness: float) -> bpy.types.Material:
    material = glass(f"Glass {roughness}", 1.5, roughness)
    for node in material.node_tree.nodes:
        if node.bl_idname == "ShaderNodeBsdfGlass":
            node.distribution = "MULTI_GGX"
    return material


def _metal(roughness: float) -> bpy.types.Material:
    return principled(f"Metallic {roughness}", _WHITE, roughness, {"Metallic": 1.0})


def _plastic(roughness: float) -> bpy.types.Material:
    return principled(f"Plastic {roughness}", _WHITE, roughness)


def _clear(roughness: float) -> bpy.types.Material:
    return principled(
        f"Transmission {roughness}", _WHITE, roughness, {"Transmission Weight": 1.0, "IOR": 1.33}
    )


ROWS = (_glossy, _metal, _plastic, _glass, _clear, _half_transparent)


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    set_world(scene, _WHITE, 1.0)
    shape = ball("Ball", 0.42, 64, 32)
    shape.materials.append(None)

    def place(name: str, material: bpy.types.Material, x: float, z: float) -> bpy.types.Object:
        item = add_object(name, shape, location=(x, 0.0, z))
        item.material_slots[0].link = "OBJECT"
        item.material_slots[0].material = material
        return item

    for row, make in enumerate(ROWS):
        for column, roughness in enumerate(ROUGHNESS):
            material = make(roughness)
            place(material.name, material, column - 3.0, 2.5 - row)
    for row, (name, kind) in enumerate(
        (("Lambert", "BsdfDiffuse"), ("Translucent", "BsdfTranslucent"))
    ):
        place(name, closure(name, kind, {"Color": _WHITE}), 2.0, 2.5 - row)
    for row, grey in enumerate(GREYS):
        item = place(f"Grey {grey}", diffuse(f"Grey {grey}", (grey, grey, grey)), 2.0, 0.5 - row)
        for ray in ("diffuse", "glossy", "transmission", "shadow", "volume_scatter"):
            setattr(item, f"visible_{ray}", False)
    add_camera(scene, (-0.5, -14.0, 0.0), (-0.5, 0.0, 0.0), lens=62.0)
    save_scene(scene, path)
