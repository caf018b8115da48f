"""Instances: places, visibility, materials of slots, random numbers."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest
from engine_core.description import Visibility


def test_a_shared_mesh_is_one_mesh(make: Any, export: Any) -> None:
    mesh = make.quad("Quad")
    for number in range(3):
        make.object(f"Quad {number}", mesh).location = (number, 0, 0)
    description = export()[0]
    assert len(description.meshes) == 1
    assert description.instances.mesh.tolist() == [0, 0, 0]
    assert description.instances.transform[:, 0, 3].tolist() == [0, 1, 2]
    assert [item.name for item in description.objects] == ["Quad 0", "Quad 1", "Quad 2"]


def test_collection_instances(make: Any, export: Any) -> None:
    collection = bpy.data.collections.new("Pair")
    for number in range(2):
        make.object(f"Part {number}", make.quad(f"Part {number}"), collection)
    bpy.data.objects["Part 1"].location = (0, 0, 5)
    for number in range(4):
        holder = make.object(f"Holder {number}", None)
        holder.location = (10 * number, 0, 0)
        holder.scale = (2, 2, 2)
        holder.instance_type, holder.instance_collection = "COLLECTION", collection
    description = export()[0]
    assert (len(description.meshes), len(description.instances.mesh)) == (2, 8)
    places = {tuple(row) for row in description.instances.transform[:, :, 3].tolist()}
    assert places == {(10.0 * i, 0.0, z) for i in range(4) for z in (0.0, 10.0)}
    assert len(set(description.instances.random.tolist())) == 8


def test_each_ray_visibility(make: Any, export: Any) -> None:
    names = ("camera", "diffuse", "glossy", "transmission", "shadow")
    for name in names:
        setattr(make.object(name, make.quad(name)), f"visible_{name}", False)
    found = dict(
        zip(
            [item.name for item in export()[0].objects],
            export()[0].instances.visibility.tolist(),
            strict=True,
        )
    )
    assert found == {name: Visibility.ALL & ~Visibility[name.upper()] for name in names}


def test_an_instance_sees_what_its_parent_allows(make: Any, export: Any) -> None:
    collection = bpy.data.collections.new("One")
    make.object("Part", make.quad("Part"), collection).visible_glossy = False
    holder = make.object("Holder", None)
    holder.instance_type, holder.instance_collection = "COLLECTION", collection
    holder.visible_shadow = False
    expected = Visibility.ALL & ~Visibility.GLOSSY & ~Visibility.SHADOW
    assert export()[0].instances.visibility.tolist() == [expected]


def test_what_no_ray_sees_is_left_out(make: Any, export: Any) -> None:
    item = make.object("Ghost", make.quad("Ghost"))
    for name in ("camera", "diffuse", "glossy", "transmission", "shadow"):
        setattr(item, f"visible_{name}", False)
    description = export()[0]
    assert (len(description.meshes), len(description.instances.mesh)) == (0, 0)


def _layer_collection(make: Any) -> Any:
    collection = bpy.data.collections.new("Group")
    bpy.context.scene.collection.children.link(collection)
    make.object("Part", make.quad("Part"), collection)
    bpy.context.view_layer.update()
    return bpy.context.view_layer.layer_collection.children["Group"]


def test_holdout_collections(make: Any, export: Any) -> None:
    _layer_collection(make).holdout = True
    assert export()[0].objects[0].holdout


def test_indirect_only_collections(make: Any, export: Any) -> None:
    _layer_collection(make).indirect_only = True
    expected = Visibility.ALL & ~Visibility.CAMERA
    assert export()[0].instances.visibility.tolist() == [expected]


def test_excluded_collections(make: Any, export: Any) -> None:
    _layer_collection(make).exclude = True
    assert len(export()[0].instances.mesh) == 0


def test_slots_of_the_object_replace_those_of_the_mesh(make: Any, export: Any) -> None:
    mesh = make.quad("Quad")
    mesh.materials.append(make.material("Of mesh"))
    make.object("Plain", mesh)
    item = make.object("Special", mesh)
    item.material_slots[0].link = "OBJECT"
    item.material_slots[0].material = make.material("Of object")
    description = export()[0]
    names = [
        [description.materials[i].name for i in description.material_sets[number]]
        for number in description.instances.material_set
    ]
    assert names == [["Of mesh"], ["Of object"]]
    assert len(description.meshes) == 1


def test_no_material_is_the_grey_default(make: Any, export: Any) -> None:
    make.object("None", make.quad("None"))
    mesh = make.quad("Empty slot")
    mesh.materials.append(None)
    make.object("Empty slot", mesh)
    description = export()[0]
    assert description.material_sets == [[-1]]
    assert description.instances.material_set.tolist() == [0, 0]


def test_material_override(make: Any, export: Any) -> None:
    mesh = make.quad("Quad")
    mesh.materials.append(make.material("Own"))
    make.object("Quad", mesh)
    bpy.context.view_layer.material_override = make.material("Override")
    assert [item.name for item in export()[0].materials] == ["Override"]


def test_zero_scale_is_ordinary(make: Any, export: Any) -> None:
    make.object("Flat", make.quad("Flat")).scale = (1, 0, 0)
    np.testing.assert_array_equal(
        export()[0].instances.transform[0, :, :3], np.diag((1.0, 0.0, 0.0))
    )


def test_transforms_that_are_not_finite_are_named(make: Any, export: Any) -> None:
    item = make.object("Lost", make.quad("Lost"))
    item.parent = make.object("Parent", None)
    item.scale = item.parent.scale = (1e30, 1, 1)
    description, messages = export()
    assert len(description.instances.mesh) == 0
    assert messages == ['object "Lost": its transform is not finite; it is left out']


def test_object_info(make: Any, export: Any) -> None:
    item = make.object("Info", make.quad("Info"))
    item.color, item.pass_index, item.location = (0.25, 0.5, 0.75, 0.5), 7, (1, 2, 3)
    item.is_shadow_catcher = True
    result = export()[0].objects[0]
    assert result.color == (0.25, 0.5, 0.75, 0.5)
    assert (result.pass_index, result.location) == (7.0, (1.0, 2.0, 3.0))
    assert result.shadow_catcher


@pytest.mark.parametrize("instanced", [False, True])
def test_random_is_that_of_cycles(
    empty_scene: Any, make: Any, export: Any, instanced: bool, tmp_path: Any
) -> None:
    """Cycles paints an object with its random number; the picture's pixel is that number."""
    material = make.material("Random")
    nodes, links = material.node_tree.nodes, material.node_tree.links
    info = nodes.new("ShaderNodeObjectInfo")
    emission = nodes.new("ShaderNodeEmission")
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(info.outputs["Random"], emission.inputs["Color"])
    links.new(emission.outputs[0], output.inputs["Surface"])
    mesh = make.quad("Quad")
    mesh.materials.append(material)
    collection = bpy.data.collections.new("One") if instanced else None
    make.object("Some name \u00e9", mesh, collection)
    if instanced:
        holder = make.object("Holder", None)
        holder.instance_type, holder.instance_collection = "COLLECTION", collection
    camera = make.camera()
    camera.location = (1, 0.5, 1)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.1
    expected = float(export()[0].instances.random[0])

    bpy.ops.preferences.addon_enable(module="cycles")
    render = empty_scene.render
    render.engine, render.resolution_x, render.resolution_y = "CYCLES", 4, 4
    empty_scene.cycles.samples, empty_scene.cycles.use_denoising = 1, False
    empty_scene.cycles.use_adaptive_sampling = False
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = str(tmp_path / "random.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(render.filepath)
    assert image.pixels[0] == pytest.approx(expected, abs=1e-6)
