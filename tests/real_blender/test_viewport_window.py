"""The 3D view in rendered mode, in Blender's window."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from .actions import RENDERED, SOLID, paint, wait_for_red
from .conftest import PICTURES, greenness, redness
from .machine import Machine
from .session import BlenderSession


def test_the_viewport_follows_edits_and_the_view(blender: BlenderSession) -> None:
    region = blender.area("VIEW_3D")
    blender.run(RENDERED)
    red = wait_for_red(blender, "viewport", region)
    # Overlays lie over the picture: the axis lines, the outline of the selected cube.
    orange = (red[..., 0] > 0.8) & (abs(red[..., 1] - 0.6) < 0.15) & (red[..., 2] < 0.3)
    assert orange.sum() > 50

    points = [(400 + 4 * i, 500 - 2 * i) for i in range(20)]
    blender.drag(2, points)
    time.sleep(2.0)
    orbited = wait_for_red(blender, "viewport_orbited", region)
    assert np.abs(orbited - red).mean() > 0.01

    paint(blender, "(0.02, 0.6, 0.02, 1.0)")
    deadline = time.monotonic() + 20.0
    while greenness(blender.picture("viewport_green")[region]) < 0.01:
        assert time.monotonic() < deadline
    assert redness(blender.picture("viewport_green")[region]) < 0.5 * redness(orbited)


def test_the_viewport_does_no_more_than_is_needed(blender: BlenderSession) -> None:
    """A moved view or camera reads nothing again; another colour compiles one material."""
    region = blender.area("VIEW_3D")
    load_viewport(blender)
    blender.run(
        """
import sys
name = next(key for key in sys.modules if key.endswith(".vernier.viewport.viewport"))
viewport = sys.modules[name]
pictures = sys.modules[name.removesuffix("viewport") + "pictures"]
store["read"], store["compiled"] = [], []
def watched_apply(self, *arguments, original=viewport.SceneSync.apply):
    store["read"].append(1)
    return original(self, *arguments)
def watched_compile(self, *arguments, original=pictures.PictureMaker._compile):
    scene = original(self, *arguments)
    store["compiled"].append(scene.compiled)
    return scene
viewport.SceneSync.apply = watched_apply
pictures.PictureMaker._compile = watched_compile
"""
    )
    blender.run(RENDERED)
    wait_for_red(blender, "needed_before", region)
    counts = 'result = [len(store["read"]), store["compiled"]]'
    blender.run('store["read"].clear(); store["compiled"].clear()')
    blender.drag(2, [(400 + 4 * i, 500 - 2 * i) for i in range(20)])
    blender.run('bpy.data.objects["Camera"].location.z += 1.0')
    blender.run('bpy.data.cameras["Camera"].lens = 35.0')
    time.sleep(1.0)
    assert blender.run(counts) == [0, []]
    paint(blender, "(0.02, 0.02, 0.6, 1.0)")
    time.sleep(1.0)
    read, compiled = blender.run(counts)
    assert read == 1
    made = {"geometry": False, "lights": False, "materials": 1, "images": 0, "changed": True}
    assert compiled == [made]


def load_viewport(blender: BlenderSession) -> None:
    """Makes Blender import the viewport's modules, as its first use does."""
    blender.run(RENDERED)
    look = 'import sys; result = any(k.endswith(".vernier.viewport.viewport") for k in sys.modules)'
    blender.wait_until(lambda: blender.run(look), 20.0, "the viewport's module")
    blender.run(SOLID)


def test_the_viewport_after_undo(blender: BlenderSession) -> None:
    region = blender.area("VIEW_3D")
    blender.run(RENDERED)
    before = wait_for_red(blender, "undo_before", region)
    blender.run(
        """
with context():
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.transform.translate(value=(0, 0, 3))
    bpy.ops.ed.undo_push(message="moved")
"""
    )
    time.sleep(2.0)
    moved = blender.picture("undo_moved")[region]
    assert np.abs(moved - before).mean() > 0.005
    blender.run("with context():\n    bpy.ops.ed.undo()")
    time.sleep(2.0)
    after = blender.picture("undo_after")[region]
    assert np.abs(after - before).mean() < 0.5 * np.abs(moved - before).mean()


def test_only_the_border_is_rendered(blender: BlenderSession) -> None:
    region = blender.area("VIEW_3D")
    blender.run(
        """
space = area("VIEW_3D").spaces[0]
space.overlay.show_overlays = False
space.use_render_border = True
space.render_border_min_x, space.render_border_max_x = 0.25, 0.5
space.render_border_min_y, space.render_border_max_y = 0.25, 0.75
bpy.context.scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.6, 0.02, 0.02, 1)
"""
    )
    blender.run(RENDERED)
    time.sleep(2.0)
    pixels = wait_for_red(blender, "viewport_border", region)
    height, width = pixels.shape[:2]
    inside = pixels[height // 4 + 9 : 3 * height // 4 - 9, width // 4 + 9 : width // 2 - 9]
    assert redness(inside) > 0.9
    assert redness(pixels[:, width // 2 + 9 :]) < 0.02


def test_the_camera_view(blender: BlenderSession) -> None:
    """The picture fits the camera's frame, as the final render has it."""
    region = blender.area("VIEW_3D")
    blender.run(
        """
space = area("VIEW_3D").spaces[0]
space.region_3d.view_perspective = "CAMERA"
space.overlay.show_overlays = False
"""
    )
    solid = blender.picture("camera_solid")[region]
    blender.run(RENDERED)
    rendered = wait_for_red(blender, "camera_rendered", region)
    # The cube is where Blender's own drawing has it: lighter or darker than the ground.
    ground = np.median(solid.reshape(-1, 3), axis=0)
    shape = np.abs(solid - ground).max(axis=2) > 0.04
    red = (rendered[..., 0] > 1.5 * rendered[..., 1]) & (rendered[..., 0] > 0.05)
    rows, columns = np.nonzero(red)
    middle = shape[
        int(np.quantile(rows, 0.2)) : int(np.quantile(rows, 0.8)),
        int(np.quantile(columns, 0.2)) : int(np.quantile(columns, 0.8)),
    ]
    assert middle.mean() > 0.9


def test_the_view_transform_counts(blender: BlenderSession) -> None:
    """A dark exposure darkens the viewport as it does the render."""
    region = blender.area("VIEW_3D")
    blender.run(RENDERED)
    bright = wait_for_red(blender, "exposure_bright", region)
    blender.run("bpy.context.scene.view_settings.exposure = -3.0")
    time.sleep(1.5)
    dark = blender.picture("exposure_dark")[region]
    cube = bright[..., 0] > 1.5 * bright[..., 1]
    assert dark[cube, 0].mean() < 0.6 * bright[cube, 0].mean()


def test_a_hundred_edits(blender: BlenderSession) -> None:
    """Edits of all kinds while the viewport renders; then the engine's memory comes back."""
    region = blender.area("VIEW_3D")
    blender.run(RENDERED)
    wait_for_red(blender, "edits_before", region)
    blender.run(
        """
import random
store["random"] = random.Random(11)
def material(r):
    item = bpy.data.materials.new("M")
    shader = item.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (r.random(), r.random(), r.random(), 1)
    shader.inputs["Metallic"].default_value = r.choice((0.0, 1.0))
    shader.inputs["Alpha"].default_value = r.choice((1.0, 0.5))
    return item
def add(r):
    with context():
        place = [r.uniform(-3, 3) for _ in range(3)]
        r.choice((bpy.ops.mesh.primitive_uv_sphere_add, bpy.ops.mesh.primitive_cube_add,
                  bpy.ops.mesh.primitive_monkey_add))(location=place)
        bpy.context.object.data.materials.append(material(r))
def meshes():
    return [o for o in bpy.context.scene.objects if o.type == "MESH"]
def remove(r):
    if len(meshes()) > 1:
        bpy.data.objects.remove(r.choice(meshes()))
def move(r):
    r.choice(meshes()).location = [r.uniform(-3, 3) for _ in range(3)]
def modify(r):
    item = r.choice(meshes())
    kind = r.choice(("SUBSURF", "BEVEL", "ARRAY"))
    item.modifiers.new("m", kind) if len(item.modifiers) < 2 else item.modifiers.clear()
def hide(r):
    item = r.choice(meshes())
    item.hide_viewport = not item.hide_viewport
def world(r):
    shade = r.random()
    node = bpy.context.scene.world.node_tree.nodes["Background"]
    node.inputs[0].default_value = (shade, shade, 1 - shade, 1)
def lamp(r):
    light = bpy.data.lights.new("L", r.choice(("POINT", "SUN", "SPOT", "AREA")))
    item = bpy.data.objects.new("L", light)
    item.location = [r.uniform(-4, 4) for _ in range(3)]
    bpy.context.scene.collection.objects.link(item)
def view(r):
    area("VIEW_3D").spaces[0].region_3d.view_distance = r.uniform(4, 15)
def undo(r):
    with context():
        bpy.ops.ed.undo_push(message="x")
        bpy.ops.object.select_all(action="TOGGLE")
def edit_mode(r):
    with context():
        bpy.context.view_layer.objects.active = r.choice(meshes())
        if not bpy.context.object.hide_viewport:
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.transform.resize(value=(0.9, 1.1, 1.0))
            bpy.ops.object.mode_set(mode="OBJECT")
def settings(r):
    bpy.context.scene.vernier.integrator = r.choice(
        bpy.context.scene.vernier.bl_rna.properties["integrator"].enum_items.keys())
def shading(r):
    space = area("VIEW_3D").spaces[0]
    space.shading.type = r.choice(("SOLID", "RENDERED"))
store["edits"] = [add, remove, move, modify, hide, world, lamp, view, undo, edit_mode, settings,
                  shading]
"""
    )
    for _ in range(100):
        blender.run(
            """
r = store["random"]
r.choice(store["edits"])(r)
"""
        )
    assert blender.alive()
    blender.run('bpy.context.scene.vernier.integrator = "PATH"\n' + RENDERED)
    time.sleep(3.0)
    pixels = blender.picture("edits_after")[region]
    assert pixels.std() > 0.02


def test_memory_returns(machine: Machine, profile: Path) -> None:
    """Leaving the engine frees what it held of a heavy scene; in a Blender that has freed nothing
    yet which could be used again."""
    blender = BlenderSession(machine, profile, PICTURES)
    try:
        blender.run(
            """
bpy.context.scene.render.engine = "VERNIER"
with context():
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=1200, y_subdivisions=1200, size=10)
"""
        )
        time.sleep(3.0)
        before = resident(blender)
        blender.run(RENDERED)
        blender.wait_until(lambda: resident(blender) > before + 200.0, 90.0, "the scene in memory")
        time.sleep(3.0)
        blender.picture("memory_rendered")
        used = resident(blender)
        blender.run('bpy.context.scene.render.engine = "BLENDER_WORKBENCH"\n' + SOLID)
        blender.wait_until(
            lambda: resident(blender) < before + 0.4 * (used - before), 30.0, "the memory's return"
        )
    finally:
        blender.close()


def resident(blender: BlenderSession) -> float:
    """Blender's memory in megabytes."""
    return float(
        blender.run(
            """
import gc
gc.collect()
with open("/proc/self/status") as file:
    rows = dict(line.split(":", 1) for line in file)
result = int(rows["VmRSS"].split()[0]) / 1024
"""
        )
    )


def test_disabling_the_extension_while_it_renders(blender: BlenderSession) -> None:
    region = blender.area("VIEW_3D")
    blender.run(RENDERED)
    wait_for_red(blender, "disable_before", region)
    module = "bl_ext.user_default.vernier"
    blender.run(f"bpy.ops.preferences.addon_disable(module={module!r})")
    time.sleep(1.0)
    blender.picture("disabled")
    assert blender.alive()
    assert not blender.run('result = hasattr(bpy.context.scene, "vernier")')
    blender.run(f"bpy.ops.preferences.addon_enable(module={module!r})")
    blender.run('bpy.context.scene.render.engine = "VERNIER"')
    blender.run(SOLID)
    blender.run(RENDERED)
    wait_for_red(blender, "enabled_again", region)
