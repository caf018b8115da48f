"""Broken scenes rendered in Blender: a message, a picture of the rest, never a crash."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from addon import record

Picture = np.ndarray
Render = Callable[[], tuple[Picture, list[str]]]


pytestmark = pytest.mark.usefixtures("registered")


@pytest.fixture
def render(empty_scene: Any, make: Any, tmp_path: Path) -> Render:
    """Renders a view from above of 4 m by 3 m: the picture, bottom row first, and the messages."""
    camera = make.camera()
    camera.location.z = 5.0
    camera.data.type, camera.data.ortho_scale = "ORTHO", 4.0
    empty_scene.vernier.samples = 2
    empty_scene.vernier.pixel_filter, empty_scene.vernier.filter_width = "BOX", 1.0
    image = empty_scene.render.image_settings
    image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGBA"
    empty_scene.render.filepath = str(tmp_path / "picture.exr")

    def run() -> tuple[Picture, list[str]]:
        messages: list[str] = []

        def listen(rendered: record.RenderRecord) -> None:
            messages.extend(rendered.messages)
            assert rendered.progress.non_finite == 0

        record.listeners.append(listen)
        try:
            assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
        finally:
            record.listeners.remove(listen)
        picture = bpy.data.images.load(empty_scene.render.filepath)
        width, height = picture.size
        pixels = np.array(picture.pixels, np.float32).reshape(height, width, 4)
        assert np.isfinite(pixels).all()
        return pixels, messages

    return run


def glowing(make: Any, color: Any) -> Any:
    """A material that emits a colour, or what a socket gives: (material, its colour's input)."""
    material = make.material("Glow")
    nodes, links = material.node_tree.nodes, material.node_tree.links
    emission, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Color"].default_value = color
    links.new(emission.outputs[0], output.inputs["Surface"])
    return material, emission.inputs["Color"]


def add_panel(make: Any, material: Any, x: float, name: str = "Panel") -> Any:
    """A panel of 2 m by 3 m whose left side is at x."""
    mesh = bpy.data.meshes.new(name)
    corners = [(x, -1.5, 0), (x + 2, -1.5, 0), (x + 2, 1.5, 0), (x, 1.5, 0)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="Map")
    mesh.materials.append(material)
    return make.object(name, mesh)


@pytest.fixture
def rest(make: Any) -> None:
    """The right half of the picture, which must be there whatever the left half is."""
    add_panel(make, glowing(make, (0.25, 0.5, 1.0, 1.0))[0], 0.0, "Rest")


def assert_rest(picture: Picture) -> None:
    np.testing.assert_allclose(picture[:, 33:, :3], np.broadcast_to((0.25, 0.5, 1.0), (48, 31, 3)))


def left(picture: Picture) -> Picture:
    return picture[:, :31, :3]


def test_coordinates_that_are_no_numbers(render: Render, make: Any, rest: None) -> None:
    broken = add_panel(make, glowing(make, (1, 1, 1, 1))[0], -2.0, "Broken")
    broken.data.vertices[0].co.x = float("nan")
    picture, messages = render()
    assert_rest(picture)
    assert not left(picture).any()
    assert ["Broken" in text and "not finite" in text for text in messages] == [True]


def test_vertices_that_do_not_exist(render: Render, make: Any, rest: None) -> None:
    broken = add_panel(make, glowing(make, (1, 1, 1, 1))[0], -2.0, "Broken")
    broken.data.attributes[".corner_vert"].data[1].value = 1_000_000
    picture, messages = render()
    assert_rest(picture)
    assert not left(picture).any()
    assert ["Broken" in text and "do not exist" in text for text in messages] == [True]


@pytest.mark.parametrize("content", [None, b"", b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR"])
def test_images_that_are_missing_empty_or_cut_off(
    render: Render, make: Any, rest: None, broken_image: Any, content: bytes | None
) -> None:
    image = broken_image(content)
    material, color = glowing(make, (1, 1, 1, 1))
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    material.node_tree.links.new(texture.outputs["Color"], color)
    add_panel(make, material, -2.0)
    picture, messages = render()
    assert_rest(picture)
    np.testing.assert_allclose(left(picture), np.broadcast_to((1.0, 0.0, 1.0), (48, 31, 3)))
    assert any(f"cannot be read ({image.filepath})" in text for text in messages)


@pytest.mark.parametrize("instances", [1, 2])
def test_singular_matrices(render: Render, make: Any, rest: None, instances: int) -> None:
    """What is flat along the view is drawn, what is flat across it has no area."""
    material, _ = glowing(make, (1, 1, 1, 1))
    panel = add_panel(make, material, -2.0)
    panel.matrix_world = Matrix.Diagonal((1.0, 1.0, 0.0, 1.0))
    if instances == 2:
        edge = make.object("Edge", panel.data)
        edge.matrix_world = Matrix.Diagonal((0.0, 1.0, 1.0, 1.0))
        point = make.object("Point", panel.data)
        point.matrix_world = Matrix.Diagonal((0.0, 0.0, 0.0, 1.0))
    picture, _ = render()
    assert_rest(picture)
    np.testing.assert_allclose(left(picture), 1.0)


def test_a_material_of_ten_thousand_nodes(render: Render, make: Any, rest: None) -> None:
    """Inversions of a colour, an even number of them, in groups: the colour itself."""
    group = bpy.data.node_groups.new("Hundred", "ShaderNodeTree")
    group.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
    begin, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    socket = begin.outputs[0]
    for _ in range(100):
        node = group.nodes.new("ShaderNodeInvert")
        group.links.new(socket, node.inputs["Color"])
        socket = node.outputs[0]
    group.links.new(socket, end.inputs[0])
    material, color = glowing(make, (1, 1, 1, 1))
    nodes, links = material.node_tree.nodes, material.node_tree.links
    # The colour differs from place to place: nothing of the chain can be computed beforehand.
    place = nodes.new("ShaderNodeNewGeometry")
    above = nodes.new("ShaderNodeVectorMath")
    above.operation = "MULTIPLY_ADD"
    above.inputs[1].default_value, above.inputs[2].default_value = (0.0,) * 3, (0.25, 0.5, 0.75)
    links.new(place.outputs["Position"], above.inputs[0])
    socket = above.outputs[0]
    for _ in range(100):
        use = nodes.new("ShaderNodeGroup")
        use.node_tree = group
        links.new(socket, use.inputs[0])
        socket = use.outputs[0]
    links.new(socket, color)
    add_panel(make, material, -2.0)
    picture, messages = render()
    assert_rest(picture)
    wanted = np.broadcast_to((0.25, 0.5, 0.75), (48, 31, 3))
    np.testing.assert_allclose(left(picture), wanted, atol=1e-3)  # 10,000 roundings
    assert messages == []


def test_no_lights(render: Render, make: Any) -> None:
    grey = make.material("Grey")
    nodes, links = grey.node_tree.nodes, grey.node_tree.links
    surface, output = nodes.new("ShaderNodeBsdfPrincipled"), nodes.new("ShaderNodeOutputMaterial")
    links.new(surface.outputs[0], output.inputs["Surface"])
    add_panel(make, grey, -2.0)
    picture, messages = render()
    assert not picture[..., :3].any()
    assert messages == []


def test_an_empty_scene(render: Render, empty_scene: Any) -> None:
    empty_scene.render.film_transparent = True
    picture, messages = render()
    assert not picture.any()
    assert messages == []


def test_a_scene_without_a_camera_is_refused(render: Render, empty_scene: Any) -> None:
    empty_scene.camera = None
    with pytest.raises(RuntimeError, match="camera"):
        render()
