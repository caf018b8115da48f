"""What all scenes share: an empty file with unbiased settings, objects, cameras, lights, saving."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import bpy
from mathutils import Euler, Matrix, Vector

Point = Sequence[float]
Color = tuple[float, float, float]


@dataclass(frozen=True)
class SceneInfo:
    """Name, purpose and film of one scene.

    `purpose` is one sentence; it is stored in the file as `scene["purpose"]` and in the text block
    README. `bounces` is Cycles' limit for every kind of bounce: high enough that what lies beyond
    is far below the noise. `exposure` is in stops and acts on the view transform only.
    """

    name: str
    purpose: str
    resolution: tuple[int, int] = (480, 320)
    samples: int = 256
    bounces: int = 64
    view_transform: str = "AgX"
    look: str = "None"
    exposure: float = 0.0


def new_scene(info: SceneInfo) -> bpy.types.Scene:
    """Empties Blender's data and returns a scene of unbiased settings and a black world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    bpy.context.preferences.filepaths.save_version = 0
    scene = bpy.context.scene
    scene.name = info.name
    scene["purpose"] = info.purpose
    bpy.data.texts.new("README").write(f"{info.name}\n\n{info.purpose}\n")
    _set_film(scene, info)
    _set_unbiased(scene, info)
    set_world(scene, (0.0, 0.0, 0.0), 0.0)
    return scene


def _set_film(scene: bpy.types.Scene, info: SceneInfo) -> None:
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = info.resolution
    render.resolution_percentage = 100
    render.filepath = f"//{info.name}"
    render.image_settings.file_format = "PNG"
    scene.display_settings.display_device = "sRGB"
    scene.view_settings.view_transform = info.view_transform
    scene.view_settings.look = info.look
    scene.view_settings.exposure = info.exposure
    scene.view_settings.gamma = 1.0


def _set_unbiased(scene: bpy.types.Scene, info: SceneInfo) -> None:
    """Switches off everything by which Cycles trades bias for noise."""
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = info.samples
    cycles.preview_samples = info.samples
    cycles.seed = 0
    cycles.use_adaptive_sampling = False
    cycles.use_preview_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.use_preview_denoising = False
    cycles.sample_clamp_direct = 0.0
    cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.caustics_reflective = True
    cycles.caustics_refractive = True
    cycles.use_fast_gi = False
    cycles.min_light_bounces = 0
    cycles.min_transparent_bounces = 0
    for kind in ("max", "diffuse", "glossy", "transmission", "volume"):
        setattr(cycles, f"{kind}_bounces", info.bounces)
    cycles.transparent_max_bounces = info.bounces
    cycles.pixel_filter_type = "BLACKMAN_HARRIS"
    cycles.filter_width = 1.5


def set_world(scene: bpy.types.Scene, color: Color, strength: float) -> bpy.types.World:
    """Gives the scene a constant world of radiance `color * strength`."""
    world = scene.world or bpy.data.worlds.new("World")
    scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1.0)
    background.inputs["Strength"].default_value = strength
    return world


def add_object(
    name: str,
    data: bpy.types.ID | None,
    material: bpy.types.Material | None = None,
    *,
    location: Point = (0.0, 0.0, 0.0),
    rotation: Point = (0.0, 0.0, 0.0),
    scale: float | Point = 1.0,
    collection: bpy.types.Collection | None = None,
) -> bpy.types.Object:
    """Links a new object. `rotation` is an XYZ Euler in degrees; the material goes to the mesh."""
    item = bpy.data.objects.new(name, data)
    item.location = location
    item.rotation_euler = [math.radians(angle) for angle in rotation]
    item.scale = (scale, scale, scale) if isinstance(scale, int | float) else scale
    if material is not None and data is not None and not data.materials:
        data.materials.append(material)
    (collection or bpy.context.scene.collection).objects.link(item)
    return item


def add_bevel(item: bpy.types.Object, width: float, segments: int = 2) -> bpy.types.Object:
    """Rounds an object's edges by `width` metres, as real edges are."""
    modifier = item.modifiers.new("Bevel", "BEVEL")
    modifier.width = width
    modifier.segments = segments
    modifier.limit_method = "ANGLE"
    modifier.harden_normals = False
    return item


def add_subdivision(item: bpy.types.Object, levels: int) -> bpy.types.Object:
    """Adds Catmull-Clark subdivision with equal viewport and render levels."""
    modifier = item.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = levels
    modifier.render_levels = levels
    return item


def look_rotation(location: Point, target: Point) -> Euler:
    """Returns the rotation that turns local -Z towards `target` with Z up."""
    direction = Vector(target) - Vector(location)
    return direction.to_track_quat("-Z", "Y").to_euler()


def add_camera(
    scene: bpy.types.Scene,
    location: Point,
    target: Point,
    lens: float = 35.0,
    sensor_width: float = 36.0,
) -> bpy.types.Object:
    """Adds the scene's camera; `lens` and `sensor_width` are in millimetres."""
    data = bpy.data.cameras.new("Camera")
    data.lens = lens
    data.sensor_fit = "HORIZONTAL"
    data.sensor_width = sensor_width
    item = add_object("Camera", data, location=location)
    item.rotation_euler = look_rotation(location, target)
    scene.camera = item
    return item


def set_focus(camera: bpy.types.Object, distance: float, f_stop: float, blades: int = 0) -> None:
    """Opens the camera's aperture: focus `distance` in metres, `blades` 0 for a round one."""
    dof = camera.data.dof
    dof.use_dof = True
    dof.focus_distance = distance
    dof.aperture_fstop = f_stop
    dof.aperture_blades = blades


def add_light(
    name: str,
    kind: str,
    power: float,
    color: Color,
    location: Point,
    target: Point | None = None,
    **settings: float | str,
) -> bpy.types.Object:
    """Adds a lamp. `kind`: POINT, SPOT, SUN or AREA; `power` in watts (for SUN in W/m^2)."""
    data = bpy.data.lights.new(name, kind)
    data.energy = power
    data.color = color
    for key, value in settings.items():
        setattr(data, key, value)
    item = add_object(name, data, location=location)
    if target is not None:
        item.rotation_euler = look_rotation(location, target)
    return item


def add_collection_instance(
    name: str,
    collection: bpy.types.Collection,
    location: Point,
    turn: float = 0.0,
    scale: float | Point = 1.0,
    parent: bpy.types.Collection | None = None,
) -> bpy.types.Object:
    """Places an instance of a whole collection; `turn` is its rotation about Z in degrees."""
    item = add_object(
        name, None, location=location, rotation=(0, 0, turn), scale=scale, collection=parent
    )
    item.instance_type = "COLLECTION"
    item.instance_collection = collection
    item.empty_display_size = 0.2
    return item


def new_collection(name: str, *, hidden: bool = False) -> bpy.types.Collection:
    """Makes a collection; a hidden one is seen only through its instances."""
    collection = bpy.data.collections.new(name)
    if not hidden:
        bpy.context.scene.collection.children.link(collection)
    return collection


def transformed(points: Sequence[Point], matrix: Matrix) -> list[tuple[float, float, float]]:
    """Applies a 4x4 matrix to points."""
    return [tuple(matrix @ Vector(point)) for point in points]


def save_scene(scene: bpy.types.Scene, path: Path) -> None:
    """Packs what is not packed yet, drops what nothing uses and saves a compressed file."""
    for image in bpy.data.images:
        if image.source in {"FILE", "GENERATED"} and image.packed_file is None and image.users:
            raise ValueError(f"image {image.name} is not packed")
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    scene.frame_set(1)
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True, relative_remap=False)


Builder = Callable[[Path], None]
