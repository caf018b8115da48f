"""Lights and cameras by name, each a function that changes the plain scene of `light_pairs.py`."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

Change = Callable[[Any], None]


def _object(scene: Any, data: Any, place: Any = (0, 0, 0), turn: Any = (0, 0, 0)) -> Any:
    import bpy

    item = bpy.data.objects.new(data.name, data)
    item.location, item.rotation_euler = place, turn
    scene.collection.objects.link(item)
    return item


def add_lamp(scene: Any, kind: str, place: Any, turn: Any, values: dict[str, Any]) -> Any:
    import bpy

    lamp = bpy.data.lights.new("lamp", kind)
    for name, value in values.items():
        setattr(lamp, name, value)
    return _object(scene, lamp, place, turn)


def _lamp(kind: str, place: Any, turn: Any, values: dict[str, Any], scene: Any) -> None:
    add_lamp(scene, kind, place, turn, values)


def lamp(
    kind: str, place: Any = (0.6, -0.4, 2.0), turn: Any = (0.2, 0.3, 0.1), **values: Any
) -> Change:
    """One lamp, above the ground unless told otherwise."""
    return partial(_lamp, kind, place, turn, values)


def set_world(scene: Any, color: Any, strength: float = 1.0) -> Any:
    """A world of one colour; returns its background node."""
    import bpy

    scene.world = bpy.data.worlds.new("world")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    tree = scene.world.node_tree
    tree.nodes.clear()
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (*color, 1.0)
    background.inputs["Strength"].default_value = strength
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    return background


def _world(scene: Any) -> None:
    set_world(scene, (0.4, 0.6, 0.9), 0.8)


def _environment(turn: float, scene: Any) -> None:
    """A picture all of whose directions differ, with a small sun, turned by a mapping."""
    import bpy

    background = set_world(scene, (0, 0, 0))
    height, width = 32, 64
    v, u = (np.mgrid[0:height, 0:width].astype(np.float32) + 0.5) / np.array(
        [[[height]], [[width]]], np.float32
    )
    sky = np.stack([0.2 + 0.8 * u, 0.3 + 0.5 * v, 0.9 - 0.6 * u * v, np.ones_like(u)], axis=-1)
    sky[25:27, 10:13, :3] = (120.0, 90.0, 60.0)
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(sky.reshape(-1))
    image.pack()
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0.1, 0.2, turn)
    place = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])


def _emitter(face_up: bool, strength: float, scene: Any) -> None:
    """A glowing quad beside the block, and a glowing ball above it."""
    import bpy

    from blend_scenes.authoring.materials import emitter

    glow = emitter("glow", (1.0, 0.7, 0.4), strength)
    mesh = bpy.data.meshes.new("panel")
    corners = [(-0.5, -0.3, 0), (0.5, -0.3, 0), (0.5, 0.3, 0), (-0.5, 0.3, 0)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3) if face_up else (3, 2, 1, 0)])
    mesh.materials.append(glow)
    _object(scene, mesh, (0.8, 0.5, 1.4), (0.6, 0.3, 0.0))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.2)
    ball = bpy.context.object
    ball.data.materials.append(glow)
    ball.location = (-0.9, -0.6, 0.6)


def _emitter_sides(sampling: str, scene: Any) -> None:
    _emitter(True, 6.0, scene)
    import bpy

    bpy.data.materials["glow"].cycles.emission_sampling = sampling


def _lamp_nodes(scene: Any) -> None:
    """A spot whose strength a node tree falls off linearly."""
    import bpy

    item = add_lamp(
        scene, "SPOT", (0.3, -0.4, 2.0), (0.15, 0.1, 0), {"energy": 30.0, "shadow_soft_size": 0.1}
    )
    light = item.data
    light.use_nodes = True
    tree = light.node_tree
    tree.nodes.clear()
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (0.3, 0.8, 1.0, 1.0)
    falloff = tree.nodes.new("ShaderNodeLightFalloff")
    falloff.inputs["Strength"].default_value = 3.0
    tree.links.new(falloff.outputs["Linear"], emission.inputs["Strength"])
    output = tree.nodes.new("ShaderNodeOutputLight")
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    del bpy


def _many(scene: Any) -> None:
    """Lamps of all kinds at once: the light tree's choice."""
    for number in range(7):
        angle = number * 0.9
        place = (1.6 * math.cos(angle), 1.6 * math.sin(angle), 0.6 + 0.2 * number)
        kind = ("POINT", "SPOT", "AREA")[number % 3]
        add_lamp(scene, kind, place, (0.2, 0.1, 0), {"energy": 10.0 + 4.0 * number})
    add_lamp(scene, "SUN", (0, 0, 0), (0.5, 0.3, 0), {"energy": 0.4, "angle": 0.1})
    set_world(scene, (0.1, 0.1, 0.2))


def _unseen(flag: str, scene: Any) -> None:
    """The block is hidden from one kind of ray."""
    set_world(scene, (0.5, 0.6, 0.8))
    add_lamp(scene, "AREA", (0.6, -0.4, 2.5), (0.2, 0.3, 0), {"energy": 60.0, "size": 0.8})
    setattr(scene.objects["block"], f"visible_{flag}", False)


def _unseen_lamp(flag: str, scene: Any) -> None:
    """A lamp hidden from one kind of ray, over a glossy block."""
    item = add_lamp(scene, "AREA", (0.3, 0.5, 1.8), (0, 0, 0), {"energy": 60.0, "size": 1.2})
    setattr(item, f"visible_{flag}", False)
    _block_material(scene, "BsdfGlossy", {"Color": (0.8, 0.7, 0.5), "Roughness": 0.3})


def _block_material(scene: Any, kind: str, inputs: dict[str, Any]) -> None:
    from blend_scenes.authoring.materials import closure

    scene.objects["block"].data.materials[0] = closure("other", kind, inputs)


def _transparent_shadow(scene: Any) -> None:
    _block_material(scene, "BsdfTransparent", {"Color": (0.8, 0.5, 0.3)})
    add_lamp(scene, "AREA", (1.0, -1.0, 2.5), (0.4, 0.4, 0), {"energy": 80.0, "size": 0.4})


def _no_shadow(scene: Any) -> None:
    add_lamp(scene, "POINT", (1.2, -1.0, 2.0), (0, 0, 0), {"energy": 80.0, "use_shadow": False})


def _camera(values: dict[str, Any], focus: dict[str, Any], scene: Any) -> None:
    data = scene.camera.data
    for name, value in values.items():
        setattr(data, name, value)
    if focus:
        data.dof.use_dof = True
        for name, value in focus.items():
            setattr(data.dof, name, value)
    _many(scene)


def camera(focus: dict[str, Any] | None = None, **values: Any) -> Change:
    return partial(_camera, values, focus or {})


def _border(crop: bool, scene: Any) -> None:
    render = scene.render
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x = 0.25, 0.75
    render.border_min_y, render.border_max_y = 0.0, 0.5
    _many(scene)


def _film(hole: str, scene: Any) -> None:
    """A transparent film; the ground is gone, the block may let through."""
    import bpy

    scene.render.film_transparent = True
    bpy.data.objects.remove(scene.objects["ground"])
    set_world(scene, (0.5, 0.6, 0.8))
    kinds = {
        "alpha": ("BsdfPrincipled", {"Base Color": (0.8, 0.3, 0.2), "Alpha": 0.4}),
        "glass": ("BsdfGlass", {"Roughness": 0.0, "IOR": 1.3}),
        "holdout": ("Holdout", {}),
    }
    if hole == "holdout":  # under an opaque film, or all would be black
        scene.render.film_transparent = False
    if hole:
        _block_material(scene, *kinds[hole])


def _filter(kind: str, scene: Any) -> None:
    scene.cycles.pixel_filter_type = scene.vernier.pixel_filter = kind
    scene.cycles.filter_width = 1.8
    scene.vernier.filter_width = 1.0 if kind == "BOX" else 1.8  # Cycles' box has one width
    scene.cycles.film_exposure = scene.vernier.film_exposure = 1.7
    _many(scene)


AREA = {"energy": 60.0}
SPOT = {"energy": 90.0, "place": (0.5, -0.4, 2.0), "turn": (0.2, 0.2, 0)}

LIGHTS: dict[str, Change] = {
    "point": lamp("POINT", energy=60.0, shadow_soft_size=0.0),
    "point_hard_ball": lamp("POINT", energy=60.0, shadow_soft_size=0.4, use_soft_falloff=False),
    "point_soft_ball": lamp("POINT", energy=60.0, shadow_soft_size=0.4, use_soft_falloff=True),
    "point_near_soft": lamp(
        "POINT", (0.5, -0.5, 0.2), energy=5.0, shadow_soft_size=0.4, use_soft_falloff=True
    ),
    "point_near_hard": lamp(
        "POINT", (0.8, -0.7, 0.2), energy=5.0, shadow_soft_size=0.4, use_soft_falloff=False
    ),
    "point_temperature": lamp(
        "POINT", energy=40.0, use_temperature=True, temperature=3200.0, exposure=0.5
    ),
    "spot": lamp("SPOT", **SPOT, shadow_soft_size=0.0, spot_blend=0.0, spot_size=0.8),
    "spot_blend": lamp("SPOT", **SPOT, shadow_soft_size=0.0, spot_blend=0.6, spot_size=1.0),
    "spot_hard_ball": lamp(
        "SPOT", **SPOT, shadow_soft_size=0.3, spot_blend=0.4, spot_size=1.2, use_soft_falloff=False
    ),
    "spot_soft_ball": lamp(
        "SPOT", **SPOT, shadow_soft_size=0.3, spot_blend=0.4, spot_size=1.2, use_soft_falloff=True
    ),
    "spot_wide": lamp("SPOT", **SPOT, shadow_soft_size=0.2, spot_blend=1.0, spot_size=3.1),
    "sun_sharp": lamp("SUN", turn=(0.5, 0.4, 0), energy=2.0, angle=0.0),
    "sun_broad": lamp("SUN", turn=(0.5, 0.4, 0), energy=2.0, angle=0.6),
    "sun_huge": lamp("SUN", turn=(0.5, 0.4, 0), energy=2.0, angle=2.6),
    "area_square": lamp("AREA", **AREA, shape="SQUARE", size=0.8),
    "area_rectangle": lamp("AREA", **AREA, shape="RECTANGLE", size=1.2, size_y=0.3),
    "area_disk": lamp("AREA", **AREA, shape="DISK", size=0.9),
    "area_ellipse": lamp("AREA", **AREA, shape="ELLIPSE", size=1.2, size_y=0.5),
    "area_spread": lamp("AREA", **AREA, shape="SQUARE", size=0.8, spread=1.0),
    "area_disk_spread": lamp("AREA", **AREA, shape="DISK", size=0.8, spread=0.5),
    "area_not_normalized": lamp("AREA", energy=8.0, size=1.5, normalize=False),
    "area_scaled": partial(_lamp, "AREA", (0.5, -0.5, 2.0), (0.3, 0.2, 0), {"energy": 60.0}),
    "lamp_nodes": _lamp_nodes,
    "mesh_emitter": partial(_emitter, True, 6.0),
    "mesh_emitter_front": partial(_emitter_sides, "FRONT"),
    "mesh_emitter_none": partial(_emitter_sides, "NONE"),
    "world": _world,
    "environment": partial(_environment, 0.0),
    "environment_turned": partial(_environment, 1.2),
    "many": _many,
    **{
        f"block_unseen_by_{flag}": partial(_unseen, flag)
        for flag in ("camera", "diffuse", "glossy", "shadow")
    },
    **{f"lamp_unseen_by_{flag}": partial(_unseen_lamp, flag) for flag in ("diffuse", "glossy")},
    "transparent_shadow": _transparent_shadow,
    "lamp_without_shadow": _no_shadow,
}

CAMERAS: dict[str, Change] = {
    "perspective": camera(lens=40.0),
    "field_of_view_vertical": camera(sensor_fit="VERTICAL", sensor_height=20.0, lens=35.0),
    "shifted": camera(shift_x=0.2, shift_y=-0.15),
    "orthographic": camera(type="ORTHO", ortho_scale=4.5),
    "orthographic_shifted": camera(type="ORTHO", ortho_scale=4.5, shift_x=0.15, shift_y=0.1),
    "clipped": camera(clip_start=6.2, clip_end=7.0),
    "orthographic_clipped": camera(type="ORTHO", ortho_scale=4.5, clip_start=6.2, clip_end=7.0),
    "focus": camera({"focus_distance": 5.0, "aperture_fstop": 0.05}),
    "focus_blades": camera(
        {
            "focus_distance": 5.0,
            "aperture_fstop": 0.05,
            "aperture_blades": 5,
            "aperture_rotation": 0.4,
            "aperture_ratio": 2.0,
        }
    ),
    "focus_orthographic": camera(
        {"focus_distance": 5.0, "aperture_fstop": 2.0}, type="ORTHO", ortho_scale=4.5
    ),
    "border": partial(_border, False),
    "border_cropped": partial(_border, True),
    "film_opaque_block": partial(_film, ""),
    "film_alpha": partial(_film, "alpha"),
    "film_glass": partial(_film, "glass"),
    "film_holdout": partial(_film, "holdout"),
    "filter_box": partial(_filter, "BOX"),
    "filter_gaussian": partial(_filter, "GAUSSIAN"),
    "filter_blackman_harris": partial(_filter, "BLACKMAN_HARRIS"),
}

CASES = {**LIGHTS, **CAMERAS}

# Those that every run of the suite makes; the marker `thorough` selects the rest.
QUICK = {
    "point",
    "point_hard_ball",
    "point_soft_ball",
    "spot_blend",
    "spot_soft_ball",
    "sun_broad",
    "area_rectangle",
    "area_ellipse",
    "area_disk_spread",
    "lamp_nodes",
    "mesh_emitter",
    "environment_turned",
    "many",
    "block_unseen_by_diffuse",
    "transparent_shadow",
    "shifted",
    "orthographic_clipped",
    "focus_blades",
    "border_cropped",
    "film_alpha",
    "filter_blackman_harris",
}
