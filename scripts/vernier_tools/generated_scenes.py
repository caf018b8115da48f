"""Measuring scenes of any size, made on the spot: a rolling surface under a sun and a sky."""

from __future__ import annotations

import math

import bpy
import numpy as np

from vernier_tools.jobs import GeneratedScene

INSTANCE_TRIANGLES = 10_000


def make(spec: GeneratedScene) -> bpy.types.Scene:
    """A new file with the scene: about `spec.triangles` triangles, 256 x 192 pixels."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    from vernier_tools.engines import enable_cycles

    enable_cycles()
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 256, 192
    scene.render.resolution_percentage = 100
    material = bpy.data.materials.new("Ground")
    if not material.node_tree:
        material.use_nodes = True
    if spec.instanced:
        patch = surface("Patch", INSTANCE_TRIANGLES, 1.0)
        patch.materials.append(material)
        place_instances(scene, patch, max(spec.triangles // INSTANCE_TRIANGLES, 1))
    else:
        ground = surface("Ground", spec.triangles, 10.0)
        ground.materials.append(material)
        scene.collection.objects.link(bpy.data.objects.new("Ground", ground))
    add_light_and_camera(scene)
    return scene


def surface(name: str, triangles: int, size: float) -> bpy.types.Mesh:
    """A square of side `size`, centred, of about `triangles` triangles with a relief of waves."""
    cells = max(round(math.sqrt(triangles / 2)), 1)
    axis = np.linspace(-size / 2, size / 2, cells + 1, dtype=np.float32)
    x, y = np.meshgrid(axis, axis)
    wave = 2 * math.pi / size
    z = 0.03 * size * np.sin(3 * wave * x) * np.cos(5 * wave * y)
    z += 0.004 * size * np.sin(41 * wave * x + 1) * np.sin(37 * wave * y)
    positions = np.stack([x, y, z], axis=2).astype(np.float32)
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).reshape(-1, 1)
    up = cells + 1
    corners = np.concatenate(
        [first, first + 1, first + up + 1, first, first + up + 1, first + up], axis=1
    )
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(positions.size // 3)
    mesh.vertices.foreach_set("co", positions.ravel())
    mesh.loops.add(corners.size)
    mesh.loops.foreach_set("vertex_index", corners.ravel().astype(np.int32))
    mesh.polygons.add(corners.size // 3)
    mesh.polygons.foreach_set("loop_start", np.arange(0, corners.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    return mesh


def place_instances(scene: bpy.types.Scene, mesh: bpy.types.Mesh, count: int) -> None:
    side = math.ceil(math.sqrt(count))
    scale = 10.0 / side
    for number in range(count):
        row, column = divmod(number, side)
        item = bpy.data.objects.new(f"Patch {number}", mesh)
        item.location = ((column + 0.5) * scale - 5.0, (row + 0.5) * scale - 5.0, 0.0)
        item.scale = (scale, scale, scale)
        scene.collection.objects.link(item)


def add_light_and_camera(scene: bpy.types.Scene) -> None:
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy = 3.0
    lamp = bpy.data.objects.new("Sun", sun)
    lamp.rotation_euler = (0.7, 0.2, 0.4)
    scene.collection.objects.link(lamp)
    world = bpy.data.worlds.new("Sky")
    if not world.node_tree:
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.6, 1.0)
    scene.world = world
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0.0, -12.0, 7.0)
    camera.rotation_euler = (math.radians(60), 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
