"""A sunlit corner of a room made of the node trees that ordinary users build."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import images
from .common import (
    SceneInfo,
    add_bevel,
    add_camera,
    add_light,
    add_object,
    new_scene,
    save_scene,
    set_world,
)
from .materials import Nodes, closure, emitter, glass, new_material, principled
from .props import add_armchair, add_framed_picture, add_table, circle, goblet, teapot, vase, vessel
from .shapes import box, boxes, grid, lathe, polygons, quad, spline, tube
from .surfaces import marble, wood

INFO = SceneInfo(
    name="textured_room",
    purpose="Ordinary users' node trees in one room: image textures on UV maps, normal map, bump, "
    "noise, checker, colour ramps, mixes, node groups, colour attributes, alpha-cut leaves, coat, "
    "sheen, metal and transmission.",
    resolution=(480, 320),
    samples=512,
    exposure=-0.2,
)


def _parquet() -> bpy.types.Material:
    """Image color, normal map and roughness from the same planks, on a named UV map."""
    color, height = images.parquet(512, 11)
    material, nodes = new_material("Parquet")
    uv = nodes.add("UVMap", uv_map="UVMap").outputs["UV"]
    place = nodes.add(
        "Mapping",
        {"Vector": uv, "Scale": (0.55, 0.55, 1.0), "Rotation": (0.0, 0.0, math.radians(90))},
    ).outputs[0]
    picture = nodes.add("TexImage", {"Vector": place}, image=images.packed_image("parquet", color))
    bumps = nodes.add(
        "TexImage",
        {"Vector": place},
        image=images.packed_image(
            "parquet_normal", images.normals_from_height(height, 1.2), data=True
        ),
    )
    normal = nodes.add(
        "NormalMap", {"Color": bumps.outputs["Color"], "Strength": 0.5}, uv_map="UVMap"
    ).outputs[0]
    red = nodes.add("SeparateColor", {"Color": picture.outputs["Color"]}).outputs["Red"]
    rough = nodes.add("Math", {0: red, 1: -0.4, 2: 0.5}, operation="MULTIPLY_ADD").outputs[0]
    shader = nodes.add(
        "BsdfPrincipled",
        {
            "Base Color": picture.outputs["Color"],
            "Roughness": rough,
            "Normal": normal,
            "Coat Weight": 0.3,
            "Coat Roughness": 0.15,
        },
    )
    nodes.output(shader.outputs[0])
    return material


def _wallpaper() -> bpy.types.Material:
    """Checker and noise over Generated coordinates, joined by mixes through a reroute."""
    material, nodes = new_material("Wallpaper")
    place = nodes.coordinates("Generated")
    checker = nodes.add(
        "TexChecker",
        {"Vector": place, "Scale": 26.0, "Color1": (0.47, 0.55, 0.5), "Color2": (0.52, 0.6, 0.55)},
    )
    noise = nodes.add("TexNoise", {"Vector": place, "Scale": 60.0, "Detail": 2.0})
    factor = nodes.math("MULTIPLY", noise.outputs["Fac"], 0.3)
    reroute = nodes.add("NodeReroute")
    nodes.tree.links.new(checker.outputs["Color"], reroute.inputs[0])
    color = nodes.mix(factor, reroute.outputs[0], (0.62, 0.66, 0.58), "MIX")
    bump = nodes.add("Bump", {"Height": noise.outputs["Fac"], "Strength": 0.12, "Distance": 0.01})
    nodes.output(
        nodes.add(
            "BsdfDiffuse", {"Color": color, "Roughness": 0.3, "Normal": bump.outputs[0]}
        ).outputs[0]
    )
    return material


def _rug() -> bpy.types.Material:
    """A woven picture with sheen and a bump from the picture itself."""
    material, nodes = new_material("Rug")
    uv = nodes.add("TexCoord").outputs["UV"]
    picture = nodes.add(
        "TexImage",
        {"Vector": uv},
        interpolation="Linear",
        image=images.packed_image("rug", images.rug(256)),
    )
    noise = nodes.add("TexNoise", {"Vector": uv, "Scale": 220.0, "Detail": 1.0})
    bump = nodes.add("Bump", {"Height": noise.outputs["Fac"], "Strength": 0.5, "Distance": 0.01})
    nodes.output(
        nodes.add(
            "BsdfPrincipled",
            {
                "Base Color": picture.outputs["Color"],
                "Roughness": 0.95,
                "Sheen Weight": 0.5,
                "Sheen Roughness": 0.4,
                "Normal": bump.outputs[0],
            },
        ).outputs[0]
    )
    return material


def _leaf() -> bpy.types.Material:
    """An alpha-cut leaf card: Principled mixed with Translucent, cut by the picture's alpha."""
    material, nodes = new_material("Leaf")
    picture = nodes.add(
        "TexImage",
        image=images.packed_image("leaf", images.leaf(128)),
        interpolation="Linear",
        extension="CLIP",
    )
    skin = nodes.add("BsdfPrincipled", {"Base Color": picture.outputs["Color"], "Roughness": 0.35})
    through = nodes.add(
        "BsdfTranslucent", {"Color": nodes.mix(0.5, picture.outputs["Color"], (0.45, 0.6, 0.05))}
    )
    body = nodes.add("MixShader", {0: 0.35, 1: skin.outputs[0], 2: through.outputs[0]})
    hole = nodes.add("BsdfTransparent")
    nodes.output(
        nodes.add(
            "MixShader", {0: picture.outputs["Alpha"], 1: hole.outputs[0], 2: body.outputs[0]}
        ).outputs[0]
    )
    return material


def _worn_group() -> bpy.types.NodeTree:
    """A node group: fades a color in spots of a noise over Object coordinates."""
    group = bpy.data.node_groups.new("Worn", "ShaderNodeTree")
    group.interface.new_socket("Color", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Amount", in_out="INPUT", socket_type="NodeSocketFloat")
    group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    nodes = Nodes(group)
    start = nodes.add("NodeGroupInput")
    noise = nodes.add(
        "TexNoise", {"Vector": nodes.coordinates("Object"), "Scale": 14.0, "Detail": 6.0}
    )
    spots = nodes.ramp(noise.outputs["Fac"], [(0.52, (0, 0, 0)), (0.6, (1, 1, 1))])
    factor = nodes.math("MULTIPLY", spots, start.outputs["Amount"])
    color = nodes.mix(factor, start.outputs["Color"], (0.82, 0.78, 0.7))
    nodes.add("NodeGroupOutput", {"Color": color})
    return group


def _painted(name: str, color: tuple[float, float, float]) -> bpy.types.Material:
    """Worn paint from the node group, with a clear coat."""
    material, nodes = new_material(name)
    group = nodes.add("Group", node_tree=_worn_group())
    nodes.set_input(group, "Color", nodes.add("RGB").outputs[0])
    group.inputs["Color"].links[0].from_socket.default_value = (*color, 1.0)
    nodes.set_input(group, "Amount", 0.8)
    nodes.output(
        nodes.add(
            "BsdfPrincipled",
            {
                "Base Color": group.outputs[0],
                "Roughness": 0.45,
                "Coat Weight": 1.0,
                "Coat Roughness": 0.05,
            },
        ).outputs[0]
    )
    return material


def _cloth(
    name: str, dark: tuple[float, float, float], light: tuple[float, float, float]
) -> bpy.types.Material:
    """Upholstery: a grazing-angle mix of two colors, sheen and a fine noise bump."""
    material, nodes = new_material(name)
    rim = nodes.add("LayerWeight", {"Blend": 0.35}).outputs["Facing"]
    place = nodes.coordinates("Object", (90.0, 90.0, 90.0))
    noise = nodes.add("TexNoise", {"Vector": place, "Scale": 1.0, "Detail": 2.0})
    bump = nodes.add("Bump", {"Height": noise.outputs["Fac"], "Strength": 0.25, "Distance": 0.01})
    tone = nodes.mix(0.25, nodes.mix(rim, dark, light), noise.outputs["Fac"], "OVERLAY")
    nodes.output(
        nodes.add(
            "BsdfPrincipled",
            {
                "Base Color": tone,
                "Roughness": 0.85,
                "Sheen Weight": 0.8,
                "Sheen Roughness": 0.3,
                "Sheen Tint": light,
                "Normal": bump.outputs[0],
            },
        ).outputs[0]
    )
    return material


def _enamel() -> bpy.types.Material:
    """Color attribute and Fresnel: a painted vase under a mirror-like glaze."""
    material, nodes = new_material("Enamel")
    paint = nodes.add("VertexColor", layer_name="Paint").outputs["Color"]
    base = nodes.add("BsdfDiffuse", {"Color": paint})
    gloss = nodes.add("BsdfAnisotropic", {"Color": (1, 1, 1), "Roughness": 0.08})
    fresnel = nodes.add("Fresnel", {"IOR": 1.5}).outputs[0]
    muted = nodes.add("Math", {0: fresnel, 1: 3.0}, operation="MULTIPLY")
    muted.mute = True
    nodes.output(
        nodes.add(
            "MixShader", {0: muted.outputs[0], 1: base.outputs[0], 2: gloss.outputs[0]}
        ).outputs[0]
    )
    return material


def _chess() -> bpy.types.Material:
    """A chess board: checker of two woods, one warped by vector maths on a noise."""
    material, nodes = new_material("Chess board")
    uv = nodes.add("TexCoord").outputs["UV"]
    noise = nodes.add("TexNoise", {"Vector": uv, "Scale": 6.0, "Detail": 3.0})
    warp = nodes.add(
        "VectorMath",
        {0: noise.outputs["Color"], 1: (0.4, 0.05, 0.0), 2: uv},
        operation="MULTIPLY_ADD",
    ).outputs[0]
    stretched = nodes.add("Mapping", {"Vector": warp, "Scale": (40.0, 3.0, 1.0)}).outputs[0]
    grain = nodes.add("TexNoise", {"Vector": stretched, "Scale": 1.0}).outputs["Fac"]
    dark = nodes.ramp(grain, [(0.35, (0.05, 0.02, 0.01)), (0.65, (0.12, 0.05, 0.025))])
    light = nodes.ramp(grain, [(0.35, (0.5, 0.33, 0.17)), (0.65, (0.68, 0.49, 0.28))])
    checker = nodes.add("TexChecker", {"Vector": uv, "Color1": dark, "Color2": light, "Scale": 8.0})
    nodes.output(
        nodes.add(
            "BsdfPrincipled",
            {"Base Color": checker.outputs["Color"], "Roughness": 0.25, "Coat Weight": 0.5},
        ).outputs[0]
    )
    return material


def _poster() -> bpy.types.Material:
    material, nodes = new_material("Poster")
    picture = nodes.add("TexImage", image=images.packed_image("poster", images.landscape(192, 256)))
    nodes.output(
        nodes.add(
            "BsdfPrincipled", {"Base Color": picture.outputs["Color"], "Roughness": 0.5}
        ).outputs[0]
    )
    return material


def _add_shell() -> None:
    """Floor, two walls and a ceiling; the window is a hole in the left wall."""
    add_object(
        "Floor",
        quad("Floor", (-2.0, -2.4, 0), (2.4, -2.4, 0), (2.4, 2, 0), (-2.0, 2, 0)),
        _parquet(),
    )
    white = principled("White paint", (0.8, 0.79, 0.76), 0.55)
    add_object("Back wall", boxes("Back wall", [((-2.1, 2.0, 0.0), (2.5, 2.1, 2.7))]), _wallpaper())
    left = [
        ((-2.1, -2.4, 0.0), (-2.0, -0.9, 2.7)),
        ((-2.1, 1.3, 0.0), (-2.0, 2.0, 2.7)),
        ((-2.1, -0.9, 0.0), (-2.0, 1.3, 0.75)),
        ((-2.1, -0.9, 2.25), (-2.0, 1.3, 2.7)),
    ]
    add_object("Window wall", boxes("Window wall", left), white)
    add_object(
        "Other walls",
        boxes(
            "Other walls",
            [((2.4, -2.4, 0.0), (2.5, 2.0, 2.7)), ((-2.1, -2.5, 0.0), (2.5, -2.4, 2.7))],
        ),
        white,
    )
    add_object("Ceiling", boxes("Ceiling", [((-2.1, -2.5, 2.7), (2.5, 2.1, 2.8))]), white)
    bars = [((-2.07, -0.9, z), (-2.03, 1.3, z + 0.045)) for z in (0.75, 1.7, 2.205)]
    bars += [((-2.075, y, 0.75), (-2.025, y + 0.045, 2.25)) for y in (-0.9, 0.18, 1.255)]
    add_bevel(add_object("Window frame", boxes("Window frame", bars), white), 0.004)
    board = [((-2.0, 1.985, 0.0), (2.4, 2.0, 0.12))]
    add_bevel(add_object("Skirting", boxes("Skirting", board), white), 0.004)


def _add_plant(location: tuple[float, float, float]) -> None:
    """A glazed pot, earth, and a crown of bent leaf cards."""
    pot = vessel("Pot", [(0.0, 0.0), (0.11, 0.0), (0.13, 0.03), (0.17, 0.2), (0.18, 0.3)], 0.012)
    add_object("Pot", pot, _painted("Pot paint", (0.035, 0.13, 0.2)), location=location)
    earth = lathe("Earth", [(0.163, 0.255), (0.0, 0.26)], 32)
    add_object("Earth", earth, principled("Earth", (0.05, 0.03, 0.02), 0.95), location=location)
    stems = principled("Stem", (0.12, 0.2, 0.05), 0.5)
    card = grid(
        "Leaf card",
        (1.0, 0.42),
        (6, 2),
        lambda x, y: -0.35 * (x + 0.5) ** 2 + 0.35 * abs(y),
        smooth=True,
    )
    card.transform(Matrix.Translation((0.5, 0, 0)))
    card.materials.append(_leaf())
    generator = np.random.default_rng(5)
    base = Vector(location) + Vector((0, 0, 0.26))
    for i in range(26):
        turn = 2.399963 * i
        rise = math.radians(25 + 55 * (i / 26) + 8 * generator.standard_normal())
        out = Vector(
            (math.cos(turn) * math.cos(rise), math.sin(turn) * math.cos(rise), math.sin(rise))
        )
        reach = 0.28 + 0.5 * i / 26 + 0.05 * generator.random()
        tip = base + out * reach
        path = spline([base, base + Vector((0, 0, 0.5 * reach)) + out * reach * 0.2, tip], 5)
        add_object("Stem", tube("Stem", path, 0.004, 6), stems)
        size = 0.26 + 0.14 * generator.random()
        item = add_object("Leaf", card, location=tip, scale=size)
        item.rotation_euler = (
            math.radians(14) * generator.standard_normal(),
            math.radians(5) - 0.55 * rise,
            turn,
        )


def _add_lamp(location: tuple[float, float, float]) -> None:
    """A brass floor lamp (brushed: anisotropic) with a translucent shade and a bulb within."""
    brass = principled(
        "Brushed brass", (0.88, 0.66, 0.32), 0.28, {"Metallic": 1.0, "Anisotropic": 0.7}
    )
    foot = lathe(
        "Lamp stand",
        [
            (0.0, 0.0),
            (0.15, 0.0),
            (0.15, 0.012),
            (0.02, 0.03),
            (0.011, 0.06),
            (0.011, 1.38),
            (0.0, 1.38),
        ],
        48,
    )
    add_object("Lamp stand", foot, brass, location=location)
    paper, nodes = new_material("Lamp shade")
    skin = nodes.add("BsdfDiffuse", {"Color": (0.8, 0.7, 0.55)})
    through = nodes.add("BsdfTranslucent", {"Color": (0.8, 0.6, 0.4)})
    nodes.output(
        nodes.add("MixShader", {0: 0.5, 1: skin.outputs[0], 2: through.outputs[0]}).outputs[0]
    )
    shade = lathe("Lamp shade", [(0.2, 1.3), (0.14, 1.62)], 64)
    add_object("Lamp shade", shade, paper, location=location)
    bulb = lathe(
        "Bulb", [(0.0, 1.38), (0.02, 1.385), (0.035, 1.42), (0.03, 1.455), (0.0, 1.47)], 24
    )
    add_object("Bulb", bulb, emitter("Bulb", (1.0, 0.75, 0.45), 220.0), location=location)


def _painted_vase() -> bpy.types.Mesh:
    """A vase with a color attribute painted in rings."""
    mesh = vase("Painted vase", 0.26)
    layer = mesh.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    palette = ((0.75, 0.7, 0.6), (0.1, 0.25, 0.5), (0.7, 0.3, 0.08), (0.75, 0.7, 0.6))
    for vertex, color in zip(mesh.vertices, layer.data, strict=True):
        band = int(vertex.co.z * 46 + 0.4 * math.sin(6 * math.atan2(vertex.co.y, vertex.co.x)))
        color.color = (*palette[band % 4], 1.0)
    return mesh


def build(path: Path) -> None:
    """Builds the scene and saves it to `path`."""
    scene = new_scene(INFO)
    set_world(scene, (0.55, 0.75, 1.0), 1.6)
    _add_shell()
    sun = add_light("Sun", "SUN", 48.0, (1.0, 0.86, 0.68), (-5, -1.6, 3.2), (0, 0, 0))
    sun.data.angle = math.radians(0.8)
    rug = grid("Rug", (1.9, 1.3), (2, 2), lambda x, y: 0.008, smooth=False)
    add_object("Rug", rug, _rug(), location=(0.15, 0.25, 0.0), rotation=(0, 0, 6))
    add_armchair(
        (0.75, 1.0, 0.0),
        -28.0,
        _cloth("Upholstery", (0.16, 0.045, 0.03), (0.62, 0.3, 0.2)),
        wood("Legs", (0.09, 0.04, 0.02), (0.2, 0.1, 0.05)),
        principled(
            "Velvet", (0.03, 0.16, 0.19), 0.7, {"Sheen Weight": 1.0, "Sheen Tint": (0.5, 0.9, 1.0)}
        ),
    )
    _add_plant((-1.3, 1.45, 0.0))
    _add_lamp((1.65, 1.55, 0.0))
    oak = wood("Oak", (0.2, 0.095, 0.04), (0.45, 0.26, 0.12), roughness=0.3, coat=0.4)
    add_table("Side table", (0.85, 0.6), 0.46, oak, (-0.35, 0.25, 0.008), 8.0, leg=0.04)
    top = 0.469
    board = box("Chess board", (0.34, 0.34, 0.02))
    for loop in board.uv_layers[0].data:
        loop.uv = (loop.uv[0] / 0.34 + 0.5, loop.uv[1] / 0.34 + 0.5)
    add_bevel(
        add_object("Chess board", board, _chess(), location=(-0.16, 0.2, top), rotation=(0, 0, 20)),
        0.002,
    )
    add_object("Painted vase", _painted_vase(), _enamel(), location=(-0.63, 0.38, top))
    add_object(
        "Goblet",
        goblet("Goblet"),
        principled("Crystal", (1, 1, 1), 0.0, {"Transmission Weight": 1.0, "IOR": 1.5}),
        location=(-0.6, 0.1, top),
    )
    add_object(
        "Teapot",
        teapot("Teapot", 0.8),
        closure("Copper", "BsdfMetallic", {"Base Color": (0.9, 0.5, 0.33), "Roughness": 0.15}),
        location=(-0.38, 0.04, top),
        rotation=(0, 0, -30),
    )
    stones = marble("Marble", (0.85, 0.83, 0.8), (0.15, 0.16, 0.18), 9.0)
    ebony = principled("Ebony", (0.02, 0.018, 0.016), 0.25, {"Coat Weight": 1.0})
    for i, (x, y, material) in enumerate(
        ((-0.2, 0.27, stones), (-0.08, 0.2, ebony), (-0.14, 0.14, stones), (-0.22, 0.16, ebony))
    ):
        pawn = lathe(
            f"Pawn {i}",
            [
                (0.0, 0.0),
                (0.014, 0.0),
                (0.014, 0.006),
                (0.006, 0.014),
                (0.005, 0.032),
                (0.009, 0.036),
                (0.0095, 0.044),
                (0.005, 0.051),
                (0.0, 0.052),
            ],
            24,
        )
        add_object("Pawn", pawn, material, location=(x, y, top + 0.0205))
    add_framed_picture("Poster", (0.72, 0.96), _poster(), oak, (-0.15, 2.0, 1.62))
    dish = tube("Ring dish", circle(0.045, 0.008, 32), 0.008, 10, loop=True)
    add_object(
        "Green ring",
        dish,
        glass("Green glass", 1.5, 0.05, (0.3, 0.9, 0.5)),
        location=(-0.2, 0.4, top),
    )
    clip = polygons(
        "Card",
        [(-0.05, -0.035, 0), (0.05, -0.035, 0), (0.05, 0.035, 0), (-0.05, 0.035, 0)],
        [(0, 1, 2, 3)],
    )
    film = principled(
        "Soap film",
        (0.1, 0.1, 0.1),
        0.1,
        {"Thin Film Thickness": 420.0, "Thin Film IOR": 1.4, "Metallic": 1.0},
    )
    add_object("Card", clip, film, location=(-0.4, 0.36, top + 0.001), rotation=(0, 0, 30))
    add_camera(scene, (0.2, -2.2, 1.3), (-0.02, 0.9, 0.72), lens=27.0)
    save_scene(scene, path)
