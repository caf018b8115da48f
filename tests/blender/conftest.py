"""Tests inside Blender: an empty file for each, and an end that 4.5 survives."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

bpy = pytest.importorskip("bpy")

_status = 0


def pytest_sessionfinish(exitstatus: int) -> None:
    global _status
    _status = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure() -> None:
    """Blender 4.5 as a module hangs in its static destructors: leave without them."""
    if bpy.app.version < (5, 0, 0):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(_status)


@pytest.fixture
def empty_scene() -> Any:
    """An empty scene with a small picture and no world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    result = bpy.context.scene
    result.render.resolution_x, result.render.resolution_y = 64, 48
    result.render.resolution_percentage = 100
    return result


@pytest.fixture
def registered(empty_scene: Any) -> Iterator[None]:
    """The add-on, chosen as the empty scene's engine."""
    import addon

    addon.register()
    empty_scene.render.engine = "VERNIER"
    yield
    addon.unregister()


@pytest.fixture
def broken_image(empty_scene: Any, tmp_path: Path) -> Callable[[bytes | None], Any]:
    """Makes an image whose file, "picture.png", holds the given bytes; none: there is no file."""

    def load(content: bytes | None) -> Any:
        path = tmp_path / "picture.png"
        path.write_bytes(b"")
        image = bpy.data.images.load(str(path))
        if content is None:
            path.unlink()
        else:
            path.write_bytes(content)
        return image

    return load


@pytest.fixture
def make(empty_scene: Any) -> SimpleNamespace:
    """Short builders: `make.object(name, data)`, `make.quad(name)`, `make.material(name)`."""

    def add_object(name: str, data: Any, collection: Any = None) -> Any:
        item = bpy.data.objects.new(name, data)
        (collection or empty_scene.collection).objects.link(item)
        return item

    def quad(name: str, uv: bool = False) -> Any:
        mesh = bpy.data.meshes.new(name)
        corners = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]
        mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
        if uv:
            layer = mesh.uv_layers.new(name="Map")
            layer.data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
        return mesh

    def material(name: str) -> Any:
        result = bpy.data.materials.new(name)
        if bpy.app.version < (5, 0, 0):
            result.use_nodes = True
        result.node_tree.nodes.clear()
        return result

    def camera(name: str = "Camera") -> Any:
        item = add_object(name, bpy.data.cameras.new(name))
        empty_scene.camera = item
        return item

    return SimpleNamespace(object=add_object, quad=quad, material=material, camera=camera)


@pytest.fixture
def export(empty_scene: Any) -> Any:
    """Exports the context's scene: (description, messages), validated."""
    from engine_core.validation import validate

    from addon.export import export_scene

    def run(**options: Any) -> Any:
        description, messages = export_scene(bpy.context.evaluated_depsgraph_get(), **options)
        validate(description)
        return description, messages

    return run
