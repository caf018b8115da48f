"""The engine in Blender's window: final renders, the viewport, edits, previews."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from .conftest import PICTURES, greenness, redness
from .machine import Machine
from .session import BlenderSession

RENDERED = 'area("VIEW_3D").spaces[0].shading.type = "RENDERED"'
SOLID = 'area("VIEW_3D").spaces[0].shading.type = "SOLID"'
SHADER = 'bpy.data.objects["Cube"].active_material.node_tree.nodes["Principled BSDF"]'


def paint(blender: BlenderSession, color: str) -> None:
    blender.run(f'{SHADER}.inputs["Base Color"].default_value = {color}')


def is_rendering(blender: BlenderSession) -> bool:
    return bool(blender.run('result = bpy.app.is_job_running("RENDER")'))


def wait_for_render(blender: BlenderSession, timeout: float = 60.0) -> None:
    blender.wait_until(lambda: not is_rendering(blender), timeout, "the render's end")


def wait_for_red(
    blender: BlenderSession, name: str, region: tuple[slice, slice], least: float = 0.01
) -> np.ndarray:
    """A screenshot of a region, as soon as enough of it is red."""
    deadline = time.monotonic() + 30.0
    while True:
        pixels = blender.picture(name)[region]
        if redness(pixels) >= least:
            return pixels
        assert time.monotonic() < deadline, f"{name}: not red in 30 s\n{blender.log()}"


def start_render(blender: BlenderSession, key: str) -> None:
    blender.move(400, 400)
    blender.key(key)
    blender.wait_until(lambda: is_rendering(blender), 30.0, "a render")


def test_f12_shows_the_picture_as_it_grows(blender: BlenderSession) -> None:
    blender.run(
        """
scene = bpy.context.scene
scene.vernier.samples = 100000
scene.render.resolution_x, scene.render.resolution_y = 960, 540
"""
    )
    start_render(blender, "F12")
    blender.wait_until(
        lambda: blender.run(
            'result = any(a.type == "IMAGE_EDITOR" for a in window().screen.areas)'
        ),
        30.0,
        "the render's editor",
    )
    region = blender.area("IMAGE_EDITOR")
    early = wait_for_red(blender, "f12_early", region)
    time.sleep(3.0)
    late = blender.picture("f12_late")[region]
    # The same picture with less noise.
    assert abs(redness(early) - redness(late)) < 0.3 * redness(late)
    assert 0.0 < np.abs(early - late).mean() < 0.05
    assert is_rendering(blender)
    blender.key("Escape")
    blender.wait_until(lambda: not is_rendering(blender), 10.0, "the end after Esc")
    kept = blender.picture("f12_cancelled")[region]
    assert redness(kept) == pytest.approx(redness(late), rel=0.3)


def test_f12_to_the_end(blender: BlenderSession) -> None:
    start_render(blender, "F12")
    wait_for_render(blender)
    time.sleep(0.5)
    pixels = blender.picture("f12_done")[blender.area("IMAGE_EDITOR")]
    assert redness(pixels) > 0.005


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


PREVIEWS = {
    "MATERIAL": ("properties_material.MATERIAL_PT_preview", "Cube", ""),
    "WORLD": (
        "",
        "Cube",
        """
node = bpy.context.scene.world.node_tree.nodes["Background"]
node.inputs["Color"].default_value = (0.8, 0.02, 0.02, 1.0)
""",
    ),
    "DATA": (
        "properties_data_light.DATA_PT_preview",
        "Light",
        "bpy.data.objects['Light'].data.color = (1.0, 0.02, 0.02)",
    ),
}


@pytest.mark.parametrize("kind", PREVIEWS)
def test_previews(blender: BlenderSession, kind: str) -> None:
    """The preview of a material, world and lamp in the properties editor, its panel open."""
    panel, item, edit = PREVIEWS[kind]
    blender.run(
        f"""
bpy.context.view_layer.objects.active = bpy.data.objects[{item!r}]
{edit}
import bl_ui
name = {panel!r}
if name:
    module, _, name = name.partition(".")
    panel = getattr(getattr(bl_ui, module), name)
else:
    panel = bpy.types.VERNIER_WORLD_PT_preview
bpy.utils.unregister_class(panel)
panel.bl_options = set()  # no longer closed where it was not seen before
panel.bl_order = -1
bpy.utils.register_class(panel)
place = area("VIEW_3D")
place.type = "PROPERTIES"
place.spaces[0].context = {kind!r}
"""
    )
    region = blender.area("PROPERTIES")
    name = f"preview_{kind.lower()}"

    def red_rows() -> int:
        """The field of the colour itself is red, too, but lower than a ball."""
        pixels = blender.picture(name)[region]
        red = (pixels[..., 0] > 1.5 * pixels[..., 1]) & (pixels[..., 0] > 0.1)
        return int((red.sum(axis=1) >= 20).sum())

    blender.wait_until(lambda: red_rows() > 60, 30.0, "a red ball")


def test_save_and_reload(blender: BlenderSession) -> None:
    region = blender.area("VIEW_3D")
    blender.run(RENDERED)
    wait_for_red(blender, "reload_before", region)
    path = blender.inside("kept.blend")
    blender.run(f"bpy.ops.wm.save_as_mainfile(filepath={path!r})")
    blender.run(f"bpy.ops.wm.open_mainfile(filepath={path!r})")
    assert blender.run("result = bpy.context.scene.render.engine") == "VERNIER"
    assert blender.run("result = bpy.context.scene.vernier.samples") == 16
    blender.run(RENDERED)  # Blender itself opens files in solid mode
    wait_for_red(blender, "reload_after", region)


def test_delete_everything_while_rendering(blender: BlenderSession) -> None:
    region = blender.area("VIEW_3D")
    blender.run(RENDERED)
    wait_for_red(blender, "delete_before", region)
    blender.run(
        """
bpy.context.scene.vernier.samples = 100000
with context():
    bpy.ops.render.render("INVOKE_DEFAULT")
"""
    )
    blender.wait_until(lambda: is_rendering(blender), 30.0, "a render")
    time.sleep(1.0)
    for name in ("Cube", "Light", "Camera"):
        blender.run(f"bpy.data.objects.remove(bpy.data.objects[{name!r}])")
        time.sleep(0.3)
    blender.run("bpy.data.orphans_purge() if hasattr(bpy.data, 'orphans_purge') else None")
    assert is_rendering(blender)
    blender.picture("delete_after")
    blender.key("Escape")
    wait_for_render(blender, 15.0)
    assert blender.alive()


def test_animation_from_the_menu(blender: BlenderSession) -> None:
    """Render > Render Animation, by its key."""
    folder = blender.inside("frames")
    blender.run(
        f"""
scene = bpy.context.scene
scene.frame_end = 3
scene.render.resolution_percentage = 25
scene.render.filepath = {folder + "/"!r}
cube = bpy.data.objects["Cube"]
cube.keyframe_insert("location", frame=1)
cube.location.z = 2
cube.keyframe_insert("location", frame=3)
"""
    )
    start_render(blender, "ctrl+F12")
    wait_for_render(blender)
    blender.picture("animation_done")
    frames = sorted(path.name for path in blender.outside("frames").iterdir())
    assert frames == ["0001.png", "0002.png", "0003.png"]


def test_settings_can_be_keyed_and_driven(blender: BlenderSession) -> None:
    values = blender.run(
        """
scene = bpy.context.scene
settings = scene.vernier
settings.samples = 4
settings.keyframe_insert("samples", frame=1)
settings.samples = 64
settings.keyframe_insert("samples", frame=11)
driver = settings.driver_add("film_exposure").driver
driver.expression = "frame * 0.5"
found = []
for frame in (1, 11):
    scene.frame_set(frame)
    evaluated = scene.evaluated_get(bpy.context.evaluated_depsgraph_get())
    found.append([evaluated.vernier.samples, evaluated.vernier.film_exposure])
result = found
"""
    )
    assert np.array(values) == pytest.approx(np.array([[4, 0.5], [64, 5.5]]))


def test_presets(blender: BlenderSession) -> None:
    found = blender.run(
        """
import os
folders = bpy.utils.preset_paths("vernier")
result = {}
for folder in folders:
    for name in sorted(os.listdir(folder)):
        if not name.endswith(".py"):
            continue
        bpy.ops.script.execute_preset(
            filepath=os.path.join(folder, name), menu_idname="VERNIER_PT_presets"
        )
        settings = bpy.context.scene.vernier
        methods = settings.bl_rna.properties["integrator"].enum_items.keys()
        result[name[:-3]] = [settings.samples, settings.integrator, "BDPT" in methods]
"""
    )
    assert set(found) == {"Preview", "Production", "Caustics", "Reference"}
    samples = [found[name][0] for name in ("Preview", "Production", "Caustics", "Reference")]
    assert samples == sorted(set(samples))
    _, method, has_bidirectional = found["Caustics"]
    assert method == ("BDPT" if has_bidirectional else "PATH")
    assert found["Reference"][1] == "PATH"


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
