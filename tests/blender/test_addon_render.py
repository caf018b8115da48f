"""F12 through the real core: pictures, passes, borders, layers, cancel, failures."""

from __future__ import annotations

import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest

from addon import engine as engine_module
from addon import progress as progress_module
from addon import session as session_module

pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def lit(empty_scene: Any, make: Any) -> Any:
    """A camera before a plane that emits 0.25, 0.5, 1 in its left half, and nothing elsewhere."""
    material = make.material("Lamp")
    nodes, links = material.node_tree.nodes, material.node_tree.links
    emission, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Color"].default_value = (0.25, 0.5, 1.0, 1.0)
    links.new(emission.outputs[0], output.inputs["Surface"])
    mesh = bpy.data.meshes.new("Half")
    mesh.from_pydata([(-9, -9, 0), (0, -9, 0), (0, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
    mesh.materials.append(material)
    make.object("Half", mesh)
    camera = make.camera()
    camera.location.z = 5.0
    camera.data.type, camera.data.ortho_scale = "ORTHO", 4.0
    empty_scene.vernier.samples = 4
    empty_scene.vernier.pixel_filter, empty_scene.vernier.filter_width = "BOX", 1.0
    return empty_scene


def _picture(scene: Any, folder: Path, name: str = "picture") -> Any:
    """Renders and reads the combined picture, (height, width, 4), bottom row first."""
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"
    scene.render.filepath = str(folder / f"{name}.exr")
    assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
    image = bpy.data.images.load(scene.render.filepath)
    width, height = image.size
    return np.array(image.pixels, np.float32).reshape(height, width, 4)


def test_the_picture(lit: Any, tmp_path: Path) -> None:
    picture = _picture(lit, tmp_path)
    assert picture.shape == (48, 64, 4)
    np.testing.assert_allclose(picture[:, :32, :3], np.broadcast_to((0.25, 0.5, 1.0), (48, 32, 3)))
    assert not picture[:, 33:, :3].any()


def test_film_exposure_and_transparency(lit: Any, tmp_path: Path) -> None:
    lit.vernier.film_exposure = 2.0
    lit.render.film_transparent = True
    picture = _picture(lit, tmp_path)
    np.testing.assert_allclose(picture[24, 10], (0.5, 1.0, 2.0, 1.0))
    np.testing.assert_allclose(picture[24, 50], (0.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize("crop", [False, True])
def test_border(lit: Any, tmp_path: Path, crop: bool) -> None:
    whole = _picture(lit, tmp_path, "whole")
    render = lit.render
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x = 0.26, 0.74
    render.border_min_y, render.border_max_y = 0.11, 0.66
    part = _picture(lit, tmp_path, "part")
    x0, x1, y0, y1 = int(0.26 * 64), int(0.74 * 64), int(0.11 * 48), int(0.66 * 48)
    if crop:
        assert part.shape[:2] == (y1 - y0, x1 - x0)
    else:
        outside = part.copy()
        outside[y0:y1, x0:x1] = 0.0
        assert not outside.any()
        part = part[y0:y1, x0:x1]
    np.testing.assert_allclose(part[:, :, :3], whole[y0:y1, x0:x1, :3], atol=0.3)
    np.testing.assert_allclose(part[:, : 31 - x0, :3], whole[y0:y1, x0:31, :3])


def test_view_layers_render_each_with_its_own_override(lit: Any, make: Any, tmp_path: Path) -> None:
    lit.view_layers.new("Second").material_override = make.material("Black")
    layers: list[Any] = []
    original = session_module.FinalRender._render

    def spy(self: Any, session: Any, picture: Any) -> Any:
        progress = original(self, session, picture)
        layers.append(float(session.read("Combined", 10, 24, 1, 1)[0, 0, 2]))
        return progress

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session_module.FinalRender, "_render", spy)
        bpy.ops.render.render()
    assert layers == [1.0, 0.0]


def test_passes_have_the_names_of_this_blender(lit: Any, tmp_path: Path) -> None:
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_diffuse_color = layer.use_pass_emit = True
    layer.vernier.use_pass_error = True
    names: list[str] = []
    original = session_module._Picture.show_all

    def spy(self: Any, final: bool) -> None:
        result = self._engine.get_result()
        names.extend(item.name for item in result.layers[0].passes)
        original(self, final)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session_module._Picture, "show_all", spy)
        bpy.ops.render.render()
    new = bpy.app.version >= (5, 0, 0)
    light = {"Diffuse Color", "Emission"} if new else {"DiffCol", "Emit"}
    assert set(names) == {"Combined", "Depth", "Error"} | light


def test_the_uv_pass_reads_the_active_map(lit: Any) -> None:
    layer = bpy.data.meshes["Half"].uv_layers.new(name="Map")
    layer.data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    bpy.context.view_layer.use_pass_uv = True
    values: list[Any] = []
    original = session_module.FinalRender._render

    def spy(self: Any, session: Any, picture: Any) -> Any:
        progress = original(self, session, picture)
        values.append(session.read("UV", 16, 24, 1, 1)[0, 0])
        return progress

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session_module.FinalRender, "_render", spy)
        bpy.ops.render.render()
    # The pixel's middle lies at x = 4 (16.5 / 64 - 0.5), on a mesh from -9 to 0; y alike.
    x, y = 4.0 * (16.5 / 64 - 0.5), 4.0 * (24.5 - 24) / 64
    np.testing.assert_allclose(values[0], ((x + 9) / 9, (y + 9) / 18, 1.0), atol=0.01)


def test_animation_reads_each_frame(lit: Any, make: Any) -> None:
    item = bpy.data.objects["Half"]
    for frame, height in ((1, 0.0), (2, -1.0)):
        item.location.z = height
        item.keyframe_insert("location", frame=frame)
    for persistent in (False, True):
        lit.render.use_persistent_data = persistent
        heights: list[float] = []
        original = session_module.SceneSync.apply

        def spy(self: Any, *arguments: Any, to: Any = heights, call: Any = original) -> Any:
            description = call(self, *arguments)
            to.append(float(description.instances.transform[0, 2, 3]))
            return description

        lit.frame_start, lit.frame_end = 1, 2
        lit.render.filepath = bpy.app.tempdir + "frame_"
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(session_module.SceneSync, "apply", spy)
            bpy.ops.render.render(animation=True)
        assert heights == [0.0, -1.0]


def test_a_failure_is_seen(lit: Any) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            session_module.SceneSync,
            "apply",
            lambda *_: (_ for _ in ()).throw(ValueError("no way")),
        )
        with pytest.raises(RuntimeError, match="no way"):
            bpy.ops.render.render()
    bpy.ops.render.render()


def test_a_fault_is_seen(lit: Any, capfd: Any) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session_module.SceneSync, "apply", lambda *_: {}["no such"])
        with pytest.raises(RuntimeError, match="Vernier failed"):
            bpy.ops.render.render()


def test_a_missing_core_is_seen(lit: Any) -> None:
    from addon.core import CoreMissingError

    def missing() -> None:
        raise CoreMissingError("Vernier's core is not installed: gone")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engine_module, "core", missing)
        with pytest.raises(RuntimeError, match="core is not installed"):
            bpy.ops.render.render()


def test_a_broken_mesh_leaves_the_rest(lit: Any, make: Any, tmp_path: Path) -> None:
    broken = make.quad("Broken")
    broken.vertices[0].co.x = float("nan")
    make.object("Broken", broken)
    assert _picture(lit, tmp_path)[24, 10, 2] == 1.0


class _Breaking:
    """An engine that is asked to stop after a while."""

    def __init__(self, engine: Any, seconds: float) -> None:
        self._engine = engine
        self._at = time.perf_counter() + seconds
        self.asked: float | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._engine, name)

    def test_break(self) -> bool:
        if time.perf_counter() < self._at:
            return False
        if self.asked is None:
            self.asked = time.perf_counter()
        return True


def test_cancel_keeps_what_there_is(lit: Any) -> None:
    lit.vernier.samples = 1 << 24
    engines: list[_Breaking] = []
    original = session_module.FinalRender.__init__

    def breaking(self: Any, engine: Any) -> None:
        engines.append(_Breaking(engine, 0.5))
        original(self, engines[-1])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session_module.FinalRender, "__init__", breaking)
        assert bpy.ops.render.render() == {"FINISHED"}
    assert engines[0].asked is not None


def test_stats_line() -> None:
    progress = SimpleNamespace(
        samples=12.0, samples_target=64, seconds_left=75.4, error=0.0213, ending=""
    )
    assert progress_module.stats_line(progress) == "Sample 12/64 | Time left 1:15 | Error 2.1 %"
    progress.ending, progress.seconds_left = "target", float("inf")
    assert progress_module.stats_line(progress) == "Sample 12/64 | Target reached | Error 2.1 %"
    progress.ending, progress.error = "", float("inf")
    assert progress_module.stats_line(progress) == "Sample 12/64"
    assert progress_module.duration(3723.0) == "1:02:03"


@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="this Blender writes such lines itself")
def test_lines_of_a_render_whose_end_is_unknown(
    empty_scene: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress_module, "is_background_render", lambda: True)
    progress = SimpleNamespace(
        samples=0.0, samples_target=8, seconds_left=float("inf"), error=float("inf"), ending=""
    )
    progress_module.ProgressLines(empty_scene, "Layer").show(progress)
    assert "Remaining" not in capsys.readouterr().out
    progress.seconds_left = 3723.5
    progress_module.ProgressLines(empty_scene, "Layer").show(progress)
    assert "| Remaining:1:02:03.50 |" in capsys.readouterr().out
