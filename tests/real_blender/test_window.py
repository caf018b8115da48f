"""Final renders, files, previews and settings in Blender's window."""

from __future__ import annotations

import time

import numpy as np
import pytest

from .actions import RENDERED, is_rendering, start_render, wait_for_red, wait_for_render
from .conftest import redness
from .session import BlenderSession


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
    # The same picture with more tiles or less noise.
    seen = (early[..., 0] > 1.5 * early[..., 1]) & (early[..., 0] > 0.2)
    assert (late[seen, 0] > 1.5 * late[seen, 1]).mean() > 0.9
    assert np.abs(early - late).mean() > 0.0
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
bpy.utils.register_class(panel)
place = area("VIEW_3D")
place.type = "PROPERTIES"
place.spaces[0].context = {kind!r}
"""
    )
    region = blender.area("PROPERTIES")
    name = f"preview_{kind.lower()}"
    blender.move(300, 650)
    blender.scroll(310, 660, 20)

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
        result[name[:-3]] = [settings.samples, settings.integrator]
"""
    )
    assert set(found) == {"Preview", "Production", "Caustics", "Reference"}
    samples = [found[name][0] for name in ("Preview", "Production", "Caustics", "Reference")]
    assert samples == sorted(set(samples))
    methods = [found[name][1] for name in ("Preview", "Production", "Caustics", "Reference")]
    assert methods == ["AUTO", "AUTO", "VCM", "BDPT"]
