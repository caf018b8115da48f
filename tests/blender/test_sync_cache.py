"""Two-phase sync: what did not change is kept, what changed is read again."""

from __future__ import annotations

from typing import Any

import bpy

from addon.sync.depsgraph import SceneSync
from addon.sync.id_map import IdMap


def _pass(sync: SceneSync) -> Any:
    """Marks by the updates since the last pass, as render engines see them, then applies."""

    def mark(scene: Any, depsgraph: Any) -> None:
        sync.mark(depsgraph)

    handlers = bpy.app.handlers
    for hooks in (handlers.depsgraph_update_post, handlers.frame_change_post):
        hooks.append(mark)
    bpy.context.scene.frame_set(bpy.context.scene.frame_current)
    bpy.context.view_layer.update()
    for hooks in (handlers.depsgraph_update_post, handlers.frame_change_post):
        hooks.remove(mark)
    return sync.apply(bpy.context.evaluated_depsgraph_get())


def _mesh(description: Any, name: str) -> Any:
    return next(mesh for mesh in description.meshes if mesh.name == name)


def test_only_what_changed_is_read_again(make: Any) -> None:
    still, moved = make.quad("Still"), make.quad("Edited")
    make.object("Still", still)
    make.object("Edited", moved)
    sync = SceneSync()
    bpy.context.view_layer.update()
    first = _pass(sync)
    moved.vertices[0].co.x = -1.0
    moved.update()
    second = _pass(sync)
    assert _mesh(second, "Still") is _mesh(first, "Still")
    assert _mesh(second, "Edited") is not _mesh(first, "Edited")
    assert _mesh(second, "Edited").positions[0, 0] == -1.0


def test_a_moved_object_keeps_its_mesh(make: Any) -> None:
    item = make.object("Item", make.quad("Item"))
    sync = SceneSync()
    bpy.context.view_layer.update()
    first = _pass(sync)
    item.location.x = 3.0
    second = _pass(sync)
    assert second.meshes[0] is first.meshes[0]
    assert second.instances.transform[0, 0, 3] == 3.0


def test_an_animated_modifier_is_read_every_frame(empty_scene: Any, make: Any) -> None:
    item = make.object("Item", make.quad("Item"))
    modifier = item.modifiers.new("Array", "ARRAY")
    for frame, count in ((1, 1), (2, 4)):
        modifier.count = count
        modifier.keyframe_insert("count", frame=frame)
    sync = SceneSync()
    counts = []
    for frame in (1, 2, 1):
        empty_scene.frame_current = frame
        counts.append(len(_pass(sync).meshes[0].face_offsets) - 1)
    assert counts == [1, 4, 1]


def test_a_new_material_that_reads_more_reads_the_mesh_again(make: Any) -> None:
    mesh = make.quad("Quad", uv=True)
    material = make.material("M")
    mesh.materials.append(material)
    make.object("Quad", mesh)
    sync = SceneSync()
    assert _pass(sync).meshes[0].attributes == []
    nodes, links = material.node_tree.nodes, material.node_tree.links
    texture, surface = nodes.new("ShaderNodeTexImage"), nodes.new("ShaderNodeEmission")
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(texture.outputs[0], surface.inputs["Color"])
    links.new(surface.outputs[0], output.inputs["Surface"])
    assert [item.name for item in _pass(sync).meshes[0].attributes] == ["Map"]


def test_id_map_forgets_what_a_pass_did_not_use() -> None:
    made: list[str] = []

    def make(name: str) -> str:
        made.append(name)
        return name

    cache: IdMap[str] = IdMap()
    for keys in (["a", "b"], ["a"], ["a", "b"]):
        cache.begin()
        for key in keys:
            cache.get((key, len(key)), lambda key=key: make(key))  # type: ignore[misc]
        cache.end()
    assert made == ["a", "b", "b"]


def test_id_map_marks_by_session_identifier() -> None:
    cache: IdMap[object] = IdMap()
    cache.begin()
    kept = cache.get(("mesh", 1), object)
    lost = cache.get(("object", 2, 3, "part 0"), object)
    cache.end()
    cache.mark({3})
    assert cache.get(("mesh", 1), object) is kept
    assert cache.get(("object", 2, 3, "part 0"), object) is not lost
