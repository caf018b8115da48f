"""Denoising in the compositor: what the button builds, and what it does to a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from addon import denoising

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def noisy(empty_scene: Any, make: Any) -> Any:
    """A grey floor under a small lamp in one colour, at one sample per pixel."""
    floor = bpy.data.meshes.new("Floor")
    floor.from_pydata([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
    make.object("Floor", floor)
    lamp = bpy.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.size = 500.0, 6.0
    make.object("Lamp", lamp).location.z = 3.0
    make.camera().location.z = 8.0
    empty_scene.vernier.samples = 1
    empty_scene.vernier.integrator = "PATH"
    return empty_scene


def picture(scene: Any, path: Path) -> Any:
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGB"
    scene.render.filepath = str(path)
    assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
    image = bpy.data.images.load(str(path))
    width, height = image.size
    return np.array(image.pixels, np.float32).reshape(height, width, 4)[..., :3]


def test_the_node_smooths_the_picture_and_keeps_its_light(noisy: Any, tmp_path: Path) -> None:
    before = picture(noisy, tmp_path / "before.exr")
    assert bpy.ops.render.vernier_denoise() == {"FINISHED"}
    after = picture(noisy, tmp_path / "after.exr")

    def roughness(image: Any) -> float:
        return float(np.abs(np.diff(image, axis=1)).mean())

    assert roughness(after) < 0.5 * roughness(before)
    assert after.mean() == pytest.approx(before.mean(), rel=0.1)


def test_it_is_off_until_asked_for_and_built_once(noisy: Any) -> None:
    layer = bpy.context.view_layer
    assert not layer.vernier.use_pass_denoising
    assert denoising.set_up(noisy, layer)
    assert layer.vernier.use_pass_denoising
    assert not denoising.set_up(noisy, layer)


def test_what_the_picture_went_to_takes_the_denoised_one(noisy: Any) -> None:
    layer = bpy.context.view_layer
    tree = denoising._tree(noisy)
    source = denoising._layers_node(tree, noisy, layer)
    blur = tree.nodes.new("CompositorNodeBlur")
    for link in list(tree.links):
        tree.links.remove(link)
    tree.links.new(source.outputs["Image"], blur.inputs["Image"])
    assert denoising.set_up(noisy, layer)
    assert blur.inputs["Image"].links[0].from_node.name == denoising.NODE
    node = tree.nodes[denoising.NODE]
    assert {s.name for s in node.inputs if s.is_linked} == {"Image", "Albedo", "Normal"}
