"""The scenes that come with the product: whole, small, self-contained and unbiased."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "blend_scenes"
NAMES = sorted(path.stem for path in FOLDER.glob("*.blend"))

# The node kinds that the engine promises to render, less the prefix ShaderNode.
NODES = {
    "BsdfPrincipled",
    "BsdfDiffuse",
    "BsdfAnisotropic",
    "BsdfMetallic",
    "BsdfGlass",
    "BsdfRefraction",
    "BsdfTranslucent",
    "BsdfTransparent",
    "Emission",
    "MixShader",
    "AddShader",
    "Background",
    "OutputMaterial",
    "OutputWorld",
    "OutputLight",
    "TexImage",
    "TexEnvironment",
    "UVMap",
    "TexCoord",
    "Mapping",
    "NormalMap",
    "Bump",
    "RGB",
    "Value",
    "Mix",
    "Math",
    "VectorMath",
    "ValToRGB",
    "CombineColor",
    "SeparateColor",
    "CombineXYZ",
    "SeparateXYZ",
    "Fresnel",
    "LayerWeight",
    "NewGeometry",
    "LightPath",
    "Attribute",
    "VertexColor",
    "TexNoise",
    "TexChecker",
    "Group",
}
MODIFIERS = {"BEVEL", "SUBSURF"}
DATA_WITH_FILES = ("libraries", "sounds", "movieclips", "cache_files", "volumes", "fonts")


def node_trees() -> list[Any]:
    """Every shader node tree of the open file."""
    owners = [*bpy.data.materials, *bpy.data.worlds, *bpy.data.lights]
    trees = [owner.node_tree for owner in owners if owner.node_tree is not None]
    return [*trees, *bpy.data.node_groups]


def open_scene(path: Path) -> Any:
    """Opens a file and returns its scene."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return bpy.context.scene


@pytest.fixture(params=NAMES)
def opened(request: pytest.FixtureRequest) -> Any:
    """Each scene in turn, opened."""
    return open_scene(FOLDER / f"{request.param}.blend")


def readme_purposes() -> dict[str, str]:
    """The table of the folder's README: scene name to purpose."""
    rows = re.findall(r"^\| `(\w+)` \| (.+) \|$", (FOLDER / "README.md").read_text(), re.M)
    return dict(rows)


def test_readme_lists_exactly_the_scenes_that_exist() -> None:
    assert sorted(readme_purposes()) == NAMES
    scripts = {path.stem for path in (FOLDER / "authoring").glob("*.py")}
    assert set(NAMES) <= scripts
    assert len(NAMES) == 12


@pytest.mark.parametrize("name", NAMES)
def test_file_is_below_four_mebibytes(name: str) -> None:
    assert (FOLDER / f"{name}.blend").stat().st_size < 4 * 2**20


def test_scene_says_its_purpose_and_has_a_camera(opened: Any) -> None:
    assert opened.camera is not None
    assert opened.camera.data.type == "PERSP"
    assert opened["purpose"] == readme_purposes()[opened.name]
    assert opened["purpose"] in bpy.data.texts["README"].as_string()


def test_scene_needs_no_other_file(opened: Any) -> None:
    for kind in DATA_WITH_FILES:
        assert len(getattr(bpy.data, kind)) == 0, kind
    for image in bpy.data.images:
        if image.source != "VIEWER":
            assert image.packed_file is not None, image.name
            assert image.has_data or image.size[0] > 0, image.name
            assert image.filepath_raw.startswith("//"), image.name


def test_scene_uses_only_nodes_and_modifiers_that_the_engine_renders(opened: Any) -> None:
    for tree in node_trees():
        kinds = {node.bl_idname for node in tree.nodes}
        shader = {
            kind.removeprefix("ShaderNode") for kind in kinds if kind.startswith("ShaderNode")
        }
        assert shader <= NODES, tree.name
        others = {kind for kind in kinds if not kind.startswith("ShaderNode")}
        assert others <= {"NodeReroute", "NodeFrame", "NodeGroupInput", "NodeGroupOutput"}
    for item in bpy.data.objects:
        assert {modifier.type for modifier in item.modifiers} <= MODIFIERS, item.name


def test_scene_renders_small_and_without_bias(opened: Any) -> None:
    render, cycles = opened.render, opened.cycles
    assert render.engine == "CYCLES"
    assert 256 <= render.resolution_x <= 512
    assert 192 <= render.resolution_y <= 384
    assert cycles.sample_clamp_direct == cycles.sample_clamp_indirect == 0.0
    assert cycles.blur_glossy == cycles.light_sampling_threshold == 0.0
    assert not cycles.use_adaptive_sampling
    assert not cycles.use_denoising
    assert cycles.caustics_reflective
    assert cycles.caustics_refractive
    assert min(cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces) >= 64
    assert min(cycles.transmission_bounces, cycles.transparent_max_bounces) >= 64
    assert cycles.pixel_filter_type == "BLACKMAN_HARRIS"
    assert cycles.filter_width == pytest.approx(1.5)


def test_scene_meshes_are_finite_and_have_materials(opened: Any) -> None:
    for item in opened.objects:
        if item.type != "MESH":
            continue
        coordinates = np.empty(3 * len(item.data.vertices), dtype=np.float32)
        item.data.attributes["position"].data.foreach_get("vector", coordinates)
        assert np.isfinite(coordinates).all(), item.name
        assert any(slot.material is not None for slot in item.material_slots), item.name


def test_forest_is_two_million_triangles_by_instances() -> None:
    open_scene(FOLDER / "forest.blend")
    drawn, instanced, kept = 0, 0, {}
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        if instance.object.type != "MESH" or not instance.show_self:
            continue
        # Evaluated meshes may share a name; objects do not.
        name, mesh = instance.object.name, instance.object.data
        if name not in kept:
            mesh.calc_loop_triangles()
            kept[name] = len(mesh.loop_triangles)
        drawn += kept[name]
        instanced += kept[name] * instance.is_instance
    assert 1.8e6 < drawn < 2.2e6
    assert instanced > 0.95 * drawn
    assert sum(kept.values()) < 0.05 * drawn


def test_many_lights_has_a_thousand_emitters() -> None:
    open_scene(FOLDER / "many_lights.blend")
    lamps = sum(item.type == "LIGHT" for item in bpy.data.objects)
    bulbs = sum(
        item.type == "MESH" and item.data.name.startswith("Bulb") for item in bpy.data.objects
    )
    assert (bulbs, lamps) == (760, 240)


def test_half_mirror_scatters_eight_tenths() -> None:
    open_scene(FOLDER / "half_mirror.blend")
    material = bpy.data.materials["Half matte, three tenths mirror"]
    nodes = {node.bl_idname: node for node in material.node_tree.nodes}
    matte, mirror = nodes["ShaderNodeBsdfDiffuse"], nodes["ShaderNodeBsdfAnisotropic"]
    assert "ShaderNodeAddShader" in nodes
    assert list(matte.inputs["Color"].default_value)[:3] == pytest.approx([0.5] * 3)
    assert list(mirror.inputs["Color"].default_value)[:3] == pytest.approx([0.3] * 3)
    assert mirror.inputs["Roughness"].default_value == 0.0


def mesh_positions() -> dict[str, np.ndarray]:
    """Vertex positions of every object of the open file, in world space, by object name."""
    result = {}
    for item in bpy.data.objects:
        if item.type == "MESH":
            points = np.empty(3 * len(item.data.vertices), dtype=np.float32)
            item.data.attributes["position"].data.foreach_get("vector", points)
            matrix = np.array(item.matrix_world)
            result[item.name] = points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    return result


@pytest.mark.parametrize("name", ["cornell_box", "half_mirror", "many_lights"])
def test_script_makes_the_saved_file(name: str, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "blend_scenes.authoring", "--folder", str(tmp_path), name]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True, timeout=120)
    open_scene(FOLDER / f"{name}.blend")
    saved = mesh_positions()
    open_scene(tmp_path / f"{name}.blend")
    made = mesh_positions()
    assert saved.keys() == made.keys()
    for key, points in saved.items():
        np.testing.assert_allclose(made[key], points, atol=1e-5, err_msg=key)
