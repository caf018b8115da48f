"""Node trees to flat graphs: groups, reroutes, muted nodes, conversions, odd trees."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest
from engine_core.description import Graph, Link

from addon.materials.reads import AttributeRead, attribute_reads
from addon.materials.translate import translate


class Tree:
    """A material's tree with one diffuse surface; `self.color` is that surface's colour input."""

    def __init__(self, material: Any) -> None:
        self.material = material
        self.nodes, self.links = material.node_tree.nodes, material.node_tree.links
        self.surface = self.nodes.new("ShaderNodeBsdfDiffuse")
        self.output = self.nodes.new("ShaderNodeOutputMaterial")
        self.links.new(self.surface.outputs[0], self.output.inputs["Surface"])
        self.color = self.surface.inputs["Color"]
        self.color.default_value = (0.5, 0.25, 0.125, 1.0)
        self.messages: list[str] = []
        self.images: list[Any] = []

    def graph(self) -> Graph:
        self.messages, self.images = [], []

        def index(image: Any, user: Any) -> int:
            self.images.append(image)
            return len(self.images) - 1

        return translate(self.material, self.material.node_tree, "it", index, self.messages.append)

    def value(self, graph: Graph | None = None) -> Any:
        """What the surface's colour reads."""
        graph = graph or self.graph()
        assert graph.surface is not None
        return graph.nodes[graph.surface.node].inputs["Color"]

    def source(self) -> Any:
        """The node that the surface's colour is linked to, and the output."""
        graph = self.graph()
        link = self.value(graph)
        return graph.nodes[link.node], link.output


@pytest.fixture
def tree(make: Any) -> Tree:
    return Tree(make.material("Material"))


def _group(name: str, kinds: dict[str, str]) -> Any:
    """A node group that passes each input on to the output of the same name."""
    group = bpy.data.node_groups.new(name, "ShaderNodeTree")
    inside = group.nodes.new("NodeGroupInput")
    out = group.nodes.new("NodeGroupOutput")
    for key, kind in kinds.items():
        group.interface.new_socket(key, in_out="INPUT", socket_type=kind)
        group.interface.new_socket(key, in_out="OUTPUT", socket_type=kind)
    for key in kinds:
        group.links.new(inside.outputs[key], out.inputs[key])
    return group


def _use(nodes: Any, group: Any) -> Any:
    node = nodes.new("ShaderNodeGroup")
    node.node_tree = group
    return node


def test_constant_surface(tree: Tree) -> None:
    graph = tree.graph()
    assert graph.surface == Link(0, "BSDF")
    assert graph.nodes[0].kind == "ShaderNodeBsdfDiffuse"
    assert graph.nodes[0].inputs == {"Color": (0.5, 0.25, 0.125, 1.0), "Roughness": 0.0}


def test_value_and_rgb_become_constants(tree: Tree) -> None:
    rgb = tree.nodes.new("ShaderNodeRGB")
    rgb.outputs[0].default_value = (0.1, 0.2, 0.3, 1.0)
    tree.links.new(rgb.outputs[0], tree.color)
    assert tree.value() == pytest.approx((0.1, 0.2, 0.3, 1.0))
    value = tree.nodes.new("ShaderNodeValue")
    value.outputs[0].default_value = 0.75
    tree.links.new(value.outputs[0], tree.color)
    assert tree.value() == (0.75, 0.75, 0.75, 1.0)


def test_nothing_unread_is_looked_at(tree: Tree) -> None:
    tree.nodes.new("ShaderNodeTexNoise")
    assert len(tree.graph().nodes) == 1


def test_reroutes_are_passed(tree: Tree) -> None:
    noise = tree.nodes.new("ShaderNodeTexNoise")
    socket = noise.outputs["Color"]
    for _ in range(3):
        reroute = tree.nodes.new("NodeReroute")
        tree.links.new(socket, reroute.inputs[0])
        socket = reroute.outputs[0]
    tree.links.new(socket, tree.color)
    node, output = tree.source()
    assert (node.kind, output) == ("ShaderNodeTexNoise", "Color")


def test_an_open_reroute_leaves_the_inputs_own_value(tree: Tree) -> None:
    reroute = tree.nodes.new("NodeReroute")
    tree.links.new(reroute.outputs[0], tree.color)
    assert tree.value() == (0.5, 0.25, 0.125, 1.0)


def test_muted_nodes_pass_their_input(tree: Tree) -> None:
    noise = tree.nodes.new("ShaderNodeTexNoise")
    invert = tree.nodes.new("ShaderNodeInvert")
    tree.links.new(noise.outputs["Color"], invert.inputs["Color"])
    tree.links.new(invert.outputs[0], tree.color)
    assert tree.source()[0].kind == "ShaderNodeInvert"
    invert.mute = True
    assert tree.source()[0].kind == "ShaderNodeTexNoise"


def test_a_muted_node_without_input_passes_that_inputs_value(tree: Tree) -> None:
    invert = tree.nodes.new("ShaderNodeInvert")
    invert.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    tree.links.new(invert.outputs[0], tree.color)
    invert.mute = True
    assert tree.value() == pytest.approx((0.1, 0.2, 0.3, 1.0))


def test_muted_links_do_not_count(tree: Tree) -> None:
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], tree.color).is_muted = True
    assert tree.value() == (0.5, 0.25, 0.125, 1.0)


def test_nested_groups(tree: Tree) -> None:
    inner = _group("Inner", {"Thing": "NodeSocketColor"})
    outer = _group("Outer", {"Thing": "NodeSocketColor"})
    outer.links.clear()
    use = _use(outer.nodes, inner)
    ends = {n.bl_idname: n for n in outer.nodes}
    outer.links.new(ends["NodeGroupInput"].outputs["Thing"], use.inputs[0])
    outer.links.new(use.outputs[0], ends["NodeGroupOutput"].inputs["Thing"])
    noise = tree.nodes.new("ShaderNodeTexNoise")
    first, second = _use(tree.nodes, outer), _use(tree.nodes, outer)
    tree.links.new(noise.outputs["Color"], first.inputs[0])
    tree.links.new(first.outputs[0], second.inputs[0])
    tree.links.new(second.outputs[0], tree.color)
    assert tree.source()[0].kind == "ShaderNodeTexNoise"
    tree.links.remove(first.inputs[0].links[0])
    first.inputs[0].default_value = (0.9, 0.8, 0.7, 1.0)
    assert tree.value() == pytest.approx((0.9, 0.8, 0.7, 1.0))


def test_a_group_used_twice_is_two_sets_of_nodes(tree: Tree) -> None:
    group = bpy.data.node_groups.new("Noise", "ShaderNodeTree")
    group.interface.new_socket("Scale", in_out="INPUT", socket_type="NodeSocketFloat")
    group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    begin, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    noise = group.nodes.new("ShaderNodeTexNoise")
    group.links.new(begin.outputs["Scale"], noise.inputs["Scale"])
    group.links.new(noise.outputs["Color"], end.inputs["Color"])
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    sockets = {s.identifier: s for s in mix.inputs}
    for key, scale in (("A_Color", 2.0), ("B_Color", 3.0)):
        use = _use(tree.nodes, group)
        use.inputs["Scale"].default_value = scale
        tree.links.new(use.outputs["Color"], sockets[key])
    tree.links.new(next(s for s in mix.outputs if s.enabled), tree.color)
    found = {n.name: n.inputs["Scale"] for n in tree.graph().nodes if "Noise" in n.kind}
    assert found == {"Group/Noise Texture": 2.0, "Group.001/Noise Texture": 3.0}


def test_a_group_without_a_tree_leaves_the_inputs_own_value(tree: Tree) -> None:
    node = _use(tree.nodes, _group("Gone", {"Thing": "NodeSocketColor"}))
    tree.links.new(node.outputs[0], tree.color)
    bpy.data.node_groups.remove(bpy.data.node_groups["Gone"])
    assert tree.value() == (0.5, 0.25, 0.125, 1.0)


def test_only_enabled_sockets(tree: Tree) -> None:
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
    tree.links.new(next(s for s in mix.outputs if s.enabled), tree.color)
    node, output = tree.source()
    assert output == "Result_Color"
    assert set(node.inputs) == {"Factor_Float", "A_Color", "B_Color"}
    assert node.params["blend_type"] == "MULTIPLY"
    assert node.params["data_type"] == "RGBA"


def test_hidden_values_are_left_to_the_core(tree: Tree) -> None:
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], tree.color)
    graph = tree.graph()
    assert "Vector" not in tree.source()[0].inputs
    assert "Normal" not in graph.nodes[0].inputs


@pytest.mark.parametrize(
    ("through", "constant", "expected"),
    [
        ("NodeSocketFloat", (1.0, 0.0, 0.0, 1.0), 0.2126),
        ("NodeSocketVector", (0.1, 0.2, 0.3, 0.5), (0.1, 0.2, 0.3)),
    ],
)
def test_constants_are_converted_on_their_way(
    tree: Tree, through: str, constant: Any, expected: Any
) -> None:
    """A colour through a group's scalar or vector comes out grey, or without its alpha."""
    outer = _use(tree.nodes, _group("Pass", {"Thing": through}))
    rgb = tree.nodes.new("ShaderNodeRGB")
    rgb.outputs[0].default_value = constant
    tree.links.new(rgb.outputs[0], outer.inputs[0])
    tree.links.new(outer.outputs[0], tree.color)
    if isinstance(expected, float):
        expected = (expected,) * 3
    assert tree.value() == pytest.approx((*expected, 1.0), abs=1e-4)


def test_links_are_converted_on_their_way(tree: Tree) -> None:
    outer = _use(tree.nodes, _group("Pass", {"Thing": "NodeSocketFloat"}))
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], outer.inputs[0])
    tree.links.new(outer.outputs[0], tree.color)
    node, output = tree.source()
    assert (node.kind, output) == ("ShaderNodeRGBToBW", "Val")


def test_a_vector_through_a_scalar_is_its_average(tree: Tree) -> None:
    outer = _use(tree.nodes, _group("Pass", {"Thing": "NodeSocketFloat"}))
    place = tree.nodes.new("ShaderNodeNewGeometry")
    tree.links.new(place.outputs["Position"], outer.inputs[0])
    tree.links.new(outer.outputs[0], tree.color)
    node, output = tree.source()
    assert (node.kind, node.params["operation"], output) == (
        "ShaderNodeVectorMath",
        "DOT_PRODUCT",
        "Value",
    )
    assert node.inputs["Vector_001"] == pytest.approx((1 / 3, 1 / 3, 1 / 3))


def test_a_colour_as_a_shader_emits(tree: Tree) -> None:
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], tree.output.inputs["Surface"])
    graph = tree.graph()
    assert graph.surface is not None
    node = graph.nodes[graph.surface.node]
    assert node.kind == "ShaderNodeEmission"
    assert graph.nodes[node.inputs["Color"].node].kind == "ShaderNodeTexNoise"  # type: ignore[union-attr]


def test_color_ramp(tree: Tree) -> None:
    node = tree.nodes.new("ShaderNodeValToRGB")
    ramp = node.color_ramp
    ramp.interpolation = "B_SPLINE"
    ramp.elements[0].position = 0.25
    ramp.elements.new(0.5).color = (1, 0, 0, 0.5)
    tree.links.new(node.outputs["Color"], tree.color)
    params = tree.source()[0].params
    rows = params["ramp"].reshape(-1, 5)  # type: ignore[union-attr]
    assert rows[:, 0].tolist() == [0.25, 0.5, 1.0]
    assert rows[1, 1:].tolist() == [1.0, 0.0, 0.0, 0.5]
    assert (params["interpolation"], params["color_mode"]) == ("B_SPLINE", "RGB")


def test_curves_are_sampled_with_the_combined_one_applied_first(tree: Tree) -> None:
    node = tree.nodes.new("ShaderNodeRGBCurve")
    curves = node.mapping.curves
    curves[3].points[1].location = (1.0, 0.5)  # all: x / 2
    curves[0].points[0].location = (0.0, 1.0)  # red: 1 - x
    curves[0].points[1].location = (1.0, 0.0)
    node.mapping.update()
    tree.links.new(node.outputs["Color"], tree.color)
    params = tree.source()[0].params
    table = params["curves"].reshape(-1, 3)  # type: ignore[union-attr]
    x = np.linspace(params["min_x"], params["max_x"], len(table))  # type: ignore[call-overload]
    np.testing.assert_allclose(table[:, 0], 1.0 - 0.5 * x, atol=2e-3)
    np.testing.assert_allclose(table[:, 1], 0.5 * x, atol=2e-3)


def test_images_are_numbered(tree: Tree) -> None:
    node = tree.nodes.new("ShaderNodeTexImage")
    tree.links.new(node.outputs["Color"], tree.color)
    assert tree.source()[0].params["image"] == -1
    node.image = bpy.data.images.new("Picture", 2, 2)
    node.interpolation, node.extension = "Closest", "CLIP"
    params = tree.source()[0].params
    assert (params["image"], params["interpolation"], params["extension"]) == (0, "Closest", "CLIP")
    assert [image.name for image in tree.images] == ["Picture"]


def test_the_active_output_counts(tree: Tree) -> None:
    other = tree.nodes.new("ShaderNodeOutputMaterial")
    glass = tree.nodes.new("ShaderNodeBsdfGlass")
    tree.links.new(glass.outputs[0], other.inputs["Surface"])
    other.is_active_output = True
    assert tree.graph().nodes[0].kind == "ShaderNodeBsdfGlass"
    other.target = "EEVEE"
    assert tree.graph().nodes[0].kind == "ShaderNodeBsdfDiffuse"


def test_no_output_and_no_surface_are_black(tree: Tree) -> None:
    tree.links.clear()
    assert tree.graph().surface is None
    tree.nodes.remove(tree.output)
    assert tree.graph().surface is None


def test_volume_and_displacement_are_named(tree: Tree) -> None:
    volume = tree.nodes.new("ShaderNodeVolumeAbsorption")
    tree.links.new(volume.outputs[0], tree.output.inputs["Volume"])
    tree.graph()
    assert tree.messages == [
        'it: volume (node "Volume Absorption") is not supported; it is left out'
    ]


def test_cycles_within_a_tree_are_cut(tree: Tree) -> None:
    first, second = (tree.nodes.new("ShaderNodeInvert") for _ in range(2))
    tree.links.new(first.outputs[0], second.inputs["Color"])
    tree.links.new(second.outputs[0], first.inputs["Color"])
    tree.links.new(second.outputs[0], tree.color)
    from engine_core.validation import check_graph

    check_graph(tree.graph(), "it", 0)


def test_cycles_through_groups_are_cut_and_named(tree: Tree) -> None:
    """Two passages through one group node: no cycle in either tree, one in the flat graph."""
    group = _group("Two", {"A": "NodeSocketColor", "B": "NodeSocketColor"})
    node = _use(tree.nodes, group)
    invert = tree.nodes.new("ShaderNodeInvert")
    tree.links.new(node.outputs["A"], invert.inputs["Color"])
    tree.links.new(invert.outputs[0], node.inputs["A"])
    tree.links.new(node.outputs["A"], tree.color)
    from engine_core.validation import check_graph

    check_graph(tree.graph(), "it", 0)


def test_ten_thousand_nodes(tree: Tree) -> None:
    """A chain of a hundred groups of a hundred nodes: Blender itself is slow at larger trees."""

    def chain(nodes: Any, links: Any, socket: Any, add: Any) -> Any:
        for _ in range(100):
            node = add(nodes)
            links.new(socket, next(s for s in node.inputs if s.type == "RGBA"))
            socket = node.outputs[0]
        return socket

    group = _group("Hundred", {"Thing": "NodeSocketColor"})
    group.links.clear()
    ends = {n.bl_idname: n for n in group.nodes}
    last = chain(
        group.nodes,
        group.links,
        ends["NodeGroupInput"].outputs[0],
        lambda nodes: nodes.new("ShaderNodeInvert"),
    )
    group.links.new(last, ends["NodeGroupOutput"].inputs[0])
    noise = tree.nodes.new("ShaderNodeTexNoise").outputs["Color"]
    tree.links.new(
        chain(tree.nodes, tree.links, noise, lambda nodes: _use(nodes, group)), tree.color
    )
    assert len(tree.graph().nodes) == 10_002


def test_repeat_zones(tree: Tree) -> None:
    if bpy.app.version < (5, 0, 0):
        pytest.skip("no zones in shader trees before 5.0")
    begin = tree.nodes.new("GeometryNodeRepeatInput")
    end = tree.nodes.new("GeometryNodeRepeatOutput")
    begin.pair_with_output(end)
    end.repeat_items.clear()
    end.repeat_items.new("RGBA", "Color")
    begin.inputs["Iterations"].default_value = 3
    noise = tree.nodes.new("ShaderNodeTexNoise")
    invert = tree.nodes.new("ShaderNodeInvert")
    tree.links.new(noise.outputs["Color"], begin.inputs["Color"])
    tree.links.new(begin.outputs["Color"], invert.inputs["Color"])
    tree.links.new(invert.outputs[0], end.inputs["Color"])
    tree.links.new(end.outputs["Color"], tree.color)
    kinds = [node.kind for node in tree.graph().nodes]
    assert kinds.count("ShaderNodeInvert") == 3
    assert kinds.count("ShaderNodeTexNoise") == 1


def test_reads(tree: Tree) -> None:
    image = tree.nodes.new("ShaderNodeTexImage")
    tree.links.new(image.outputs["Color"], tree.color)
    assert attribute_reads(tree.graph()) == {AttributeRead("uv", "")}
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], image.inputs["Vector"])
    assert attribute_reads(tree.graph()) == frozenset()


def test_material_without_nodes(make: Any, export: Any) -> None:
    if bpy.app.version >= (5, 0, 0):
        pytest.skip("materials always have nodes from 5.0 on")
    material = bpy.data.materials.new("Plain")
    material.diffuse_color = (0.1, 0.2, 0.3, 1.0)
    mesh = make.quad("Quad")
    mesh.materials.append(material)
    make.object("Quad", mesh)
    node = export()[0].materials[0].graph.nodes[0]
    assert node.kind == "ShaderNodeBsdfDiffuse"
    assert node.inputs["Color"] == pytest.approx((0.1, 0.2, 0.3, 1.0))
