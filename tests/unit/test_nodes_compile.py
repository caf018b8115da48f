"""Compilation of node graphs: validation, folding, fallbacks, and graphs of any depth."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from engine_core.description import Graph, Image, Link, Node
from node_graphs import emission_of, points, value_of

from engine_core import probe

DIFFUSE = "ShaderNodeBsdfDiffuse"


def test_constant_graphs_run_no_program() -> None:
    graph = Graph(
        [
            Node("ShaderNodeMath", "sum", {"Value": 2.0, "Value_001": 3.0}, {"operation": "ADD"}),
            Node(
                "ShaderNodeMix",
                "mix",
                {"Factor_Float": 0.5, "A_Float": Link(0, "Value"), "B_Float": 7.0},
                {"data_type": "FLOAT"},
            ),
            Node(
                "ShaderNodeEmission",
                "e",
                {"Color": (1.0, 0.5, 0.25, 1.0), "Strength": Link(1, "Result_Float")},
            ),
        ],
        Link(2, "Emission"),
    )
    material = probe.compile_graph(graph)
    traits = material.traits
    assert material.warnings == []
    assert traits["program_length"] == 0
    assert traits["is_constant"]
    assert traits["emission_constant"]
    assert traits["average_emission"] == pytest.approx((6.0, 3.0, 1.5), rel=1e-6)


def test_dead_nodes_and_unread_outputs_cost_nothing() -> None:
    noise = Node("ShaderNodeTexNoise", "noise")
    graph = Graph([noise, Node(DIFFUSE, "d", {"Color": (0.1, 0.2, 0.3, 1.0)})], Link(1, "BSDF"))
    assert probe.compile_graph(graph).traits["program_length"] == 0


@pytest.mark.parametrize(("factor", "emission"), [(0.0, 1.0), (1.0, 2.0), (-3.0, 1.0), (4.0, 2.0)])
def test_mix_shader_drops_the_side_that_is_not_seen(factor: float, emission: float) -> None:
    graph = Graph(
        [
            Node("ShaderNodeTexNoise", "a"),
            Node("ShaderNodeTexNoise", "b"),
            Node("ShaderNodeEmission", "ea", {"Color": Link(0, "Color"), "Strength": 0.0}),
            Node("ShaderNodeEmission", "eb", {"Color": Link(1, "Color"), "Strength": 0.0}),
            Node("ShaderNodeEmission", "one", {"Strength": 1.0}),
            Node("ShaderNodeEmission", "two", {"Strength": 2.0}),
            Node("ShaderNodeAddShader", "left", {"Shader": Link(4, "Emission")}),
            Node(
                "ShaderNodeMixShader",
                "mix",
                {"Fac": factor, "Shader": Link(6, "Shader"), "Shader_001": Link(5, "Emission")},
            ),
        ],
        Link(7, "Shader"),
    )
    material = probe.compile_graph(graph)
    assert material.traits["program_length"] == 0
    assert material.traits["average_emission"] == pytest.approx((emission,) * 3)


def test_weights_of_shared_shaders_add_up() -> None:
    # e reaches the surface twice: 0.25 * 0.5 + 0.75 of it.
    graph = Graph(
        [
            Node("ShaderNodeEmission", "e", {"Strength": 8.0}),
            Node("ShaderNodeBsdfTransparent", "t"),
            Node(
                "ShaderNodeMixShader",
                "inner",
                {"Fac": 0.5, "Shader": Link(0, "Emission"), "Shader_001": Link(1, "BSDF")},
            ),
            Node(
                "ShaderNodeMixShader",
                "outer",
                {"Fac": 0.75, "Shader": Link(2, "Shader"), "Shader_001": Link(0, "Emission")},
            ),
        ],
        Link(3, "Shader"),
    )
    material = probe.compile_graph(graph)
    assert material.traits["average_emission"][0] == pytest.approx(7.0)
    p, n, wo = points(1)
    assert material.transparency(p, n, wo)[0, 0] == pytest.approx(0.125)


def test_ten_thousand_nodes_in_a_chain() -> None:
    count = 12_000
    nodes = [Node("ShaderNodeNewGeometry", "start")]
    for i in range(count):
        source = Link(i, "Value") if i else Link(0, "Position")
        nodes.append(Node("ShaderNodeMath", f"m{i}", {"Value": source, "Value_001": 1.0}))
    graph = Graph(nodes, Link(count, "Value"))
    material = probe.compile_graph(graph)
    assert material.traits["registers"] <= 2
    p, n, wo = points(4)
    expected = p.mean(axis=1) + count
    np.testing.assert_allclose(material.emission(p, n, wo)[:, 0], expected, rtol=1e-5)


def test_ten_thousand_shaders_in_a_tree() -> None:
    count = 5_000
    nodes = [Node("ShaderNodeEmission", "e0", {"Strength": 1.0})]
    for i in range(count):
        nodes.append(Node("ShaderNodeEmission", f"e{i}", {"Strength": 1.0}))
        previous = Link(2 * i, "Shader") if i else Link(0, "Emission")
        nodes.append(
            Node(
                "ShaderNodeAddShader",
                f"a{i}",
                {"Shader": previous, "Shader_001": Link(2 * i + 1, "Emission")},
            )
        )
    material = probe.compile_graph(Graph(nodes, Link(2 * count, "Shader")))
    assert material.traits["average_emission"][0] == pytest.approx(count + 1, rel=1e-4)


def test_many_live_values_still_evaluate() -> None:
    # 200 noises that all live until the last sum: more registers than fit beside the stack frame.
    nodes = [Node("ShaderNodeNewGeometry", "g")]
    for i in range(200):
        nodes.append(
            Node(
                "ShaderNodeVectorMath",
                f"s{i}",
                {"Vector": Link(0, "Position"), "Scale": float(i)},
                {"operation": "SCALE"},
            )
        )
    nodes.append(Node("ShaderNodeBsdfTransparent", "t"))
    shaders = []
    for i in range(200):
        nodes.append(Node("ShaderNodeEmission", f"e{i}", {"Color": Link(1 + i, "Vector")}))
        shaders.append(len(nodes) - 1)
    top = Link(shaders[0], "Emission")
    for s in shaders[1:]:
        nodes.append(
            Node("ShaderNodeAddShader", "a", {"Shader": top, "Shader_001": Link(s, "Emission")})
        )
        top = Link(len(nodes) - 1, "Shader")
    material = probe.compile_graph(Graph(nodes, top))
    assert material.traits["registers"] > 64
    p, n, wo = points(8)
    total = sum(range(200))
    np.testing.assert_allclose(material.emission(p, n, wo), p * total, rtol=1e-4)


@pytest.mark.parametrize(
    "nodes",
    [
        [Node("ShaderNodeMath", "loop", {"Value": Link(0, "Value")})],
        [
            Node("ShaderNodeMath", "one", {"Value": Link(1, "Value")}),
            Node("ShaderNodeMath", "loop", {"Value": Link(0, "Value")}),
        ],
    ],
)
def test_cycles_are_refused_by_name(nodes: list[Node]) -> None:
    with pytest.raises(ValueError, match=r"'probe'.*cycle"):
        probe.compile_graph(Graph(nodes, Link(0, "Value")))


def test_links_out_of_range_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"'probe', node 'm'.*'Value'.*7 of 1"):
        value_of([Node("ShaderNodeMath", "m", {"Value": Link(7, "Value")})], "Value")
    with pytest.raises(ValueError, match=r"surface is node 3 of 0"):
        probe.compile_graph(Graph([], Link(3, "Value")))


def test_unknown_kinds_are_named_and_pass_their_first_link_on() -> None:
    nodes = [
        Node("ShaderNodeNewGeometry", "g"),
        Node("ShaderNodeFromTheFuture", "new", {"Amount": 3.0, "Vector": Link(0, "Position")}),
        Node(
            "ShaderNodeVectorMath",
            "scale",
            {"Vector": Link(1, "Whatever"), "Scale": 2.0},
            {"operation": "SCALE"},
        ),
    ]
    material = probe.compile_graph(Graph(nodes, Link(2, "Vector")), "Steel")
    assert len(material.warnings) == 1
    assert "'Steel'" in material.warnings[0]
    assert "'new' (ShaderNodeFromTheFuture)" in material.warnings[0]
    p, n, wo = points(5)
    np.testing.assert_allclose(material.emission(p, n, wo), 2 * p, rtol=1e-6)


def test_unknown_shaders_are_grey_and_never_black() -> None:
    graph = Graph([Node("ShaderNodeBsdfFromTheFuture", "new")], Link(0, "BSDF"))
    material = probe.compile_graph(graph)
    assert material.traits["lobes"] != 0
    assert len(material.warnings) == 1


@pytest.mark.parametrize(
    ("node", "what"),
    [
        (Node("ShaderNodeMath", "m", {}, {"operation": "SUMMON"}), "'SUMMON'"),
        (Node("ShaderNodeMath", "m", {}, {"colour": "blue"}), "'colour'"),
        (Node("ShaderNodeMath", "m", {"Velocity": 1.0}), "'Velocity'"),
    ],
)
def test_unknown_parts_of_nodes_are_named(node: Node, what: str) -> None:
    material = probe.compile_graph(Graph([node], Link(0, "Value")))
    assert len(material.warnings) == 1
    assert what in material.warnings[0]
    assert "'m' (ShaderNodeMath)" in material.warnings[0]


def test_a_missing_image_is_magenta_and_named() -> None:
    missing = Image("lost.png", None)
    for index, name in ((0, "lost.png"), (-1, "no image"), (9, "no image")):
        node = Node("ShaderNodeTexImage", "tex", {}, {"image": index})
        material = probe.compile_graph(Graph([node], Link(0, "Color")), "m", [missing])
        p, n, wo = points(3)
        np.testing.assert_array_equal(material.emission(p, n, wo), [[1, 0, 1]] * 3)
        assert any(name in warning for warning in material.warnings)


def test_equal_subexpressions_are_computed_once() -> None:
    nodes = [
        Node("ShaderNodeTexNoise", "a"),
        Node("ShaderNodeTexNoise", "b"),
        Node("ShaderNodeMath", "sum", {"Value": Link(0, "Fac"), "Value_001": Link(1, "Fac")}),
    ]
    single = probe.compile_graph(Graph(nodes[:1], Link(0, "Fac"))).traits["program_length"]
    both = probe.compile_graph(Graph(nodes, Link(2, "Value"))).traits["program_length"]
    assert both == single + 1


def noises(vectors: list[int], gains: list[float], dimensions: str) -> list[Node]:
    """Noises of what the nodes of these indices give, and their sum weighted by powers of two.

    Nodes 0 to 2 are coordinates, the noises come after them. An fBm does not read its gain.
    """
    geometry, far = Node("ShaderNodeNewGeometry", "g"), {"Vector_001": (3.0, 5.0, 7.0)}
    nodes = [geometry] + [
        Node(
            "ShaderNodeVectorMath",
            kind,
            {"Vector": Link(0, "Position"), **far},
            {"operation": kind},
        )
        for kind in ("ADD", "MULTIPLY")
    ]
    outputs = ["Position", "Vector", "Vector"] + ["Color"] * len(vectors)
    for vector, gain in zip(vectors, gains, strict=True):
        link = Link(vector, outputs[vector])
        inputs: dict[str, Any] = {
            "Vector": link,
            "W": 0.3,
            "Detail": 4.5,
            "Distortion": 0.2,
            "Gain": gain,
        }
        nodes.append(Node("ShaderNodeTexNoise", "n", inputs, {"noise_dimensions": dimensions}))
    for i in range(len(vectors)):
        sum_so_far = Link(len(nodes) - 1, "Vector") if i > 0 else (0.0, 0.0, 0.0)
        inputs = {"Vector": Link(3 + i, "Color"), "Vector_001": (2.0**i,) * 3}
        inputs["Vector_002"] = sum_so_far
        nodes.append(Node("ShaderNodeVectorMath", "w", inputs, {"operation": "MULTIPLY_ADD"}))
    return nodes


@pytest.mark.parametrize("dimensions", ["2D", "3D", "4D"])
@pytest.mark.parametrize(
    "vectors", [[0, 1, 2], [0, 1], [0, 1, 2, 3], [0, 3, 4], [0, 1, 3, 2], [2, 3, 1, 4, 0, 5, 6]]
)
def test_noises_that_are_evaluated_together_keep_their_values(
    vectors: list[int], dimensions: str
) -> None:
    count = len(vectors)
    together = noises(vectors, [1.0] * count, dimensions)
    alone = noises(vectors, [1.0 + i for i in range(count)], dimensions)
    values = value_of(together, "Vector", 32)
    assert np.ptp(values) > 0.1
    np.testing.assert_array_equal(values, value_of(alone, "Vector", 32))


def test_a_mapping_that_moves_nothing_costs_nothing() -> None:
    def mapped(scale: float) -> list[Node]:
        moved: dict[str, Any] = {"Vector": Link(0, "Position"), "Scale": (scale,) * 3}
        mapping = Node("ShaderNodeMapping", "m", moved, {"vector_type": "POINT"})
        return [Node("ShaderNodeNewGeometry", "g"), mapping]

    lengths = [
        probe.compile_graph(Graph(mapped(scale), Link(1, "Vector"))).traits["program_length"]
        for scale in (1.0, 2.0)
    ]
    assert lengths[0] == lengths[1] - 1
    np.testing.assert_array_equal(value_of(mapped(1.0), "Vector", 8), points(8)[0])


def test_attributes_that_are_read_are_listed() -> None:
    nodes = [
        Node("ShaderNodeAttribute", "a", {}, {"attribute_name": "wear"}),
        Node("ShaderNodeUVMap", "uv", {}, {"uv_map": "UVMap"}),
        Node("ShaderNodeNormalMap", "n", {"Strength": 0.5}, {"uv_map": "UVMap"}),
        Node("ShaderNodeAttribute", "dead", {}, {"attribute_name": "unread"}),
        Node(
            DIFFUSE,
            "d",
            {"Color": Link(1, "UV"), "Roughness": Link(0, "Fac"), "Normal": Link(2, "Normal")},
        ),
    ]
    traits = probe.compile_graph(Graph(nodes, Link(4, "BSDF"))).traits
    assert sorted(traits["attributes"]) == ["UVMap", "tangent:UVMap", "wear"]
    assert traits["uses_bump"]


def test_traits_of_surfaces() -> None:
    def traits(node: Node, output: str) -> dict[str, Any]:
        return dict(probe.compile_graph(Graph([node], Link(0, output))).traits)

    plain = traits(Node(DIFFUSE, "d"), "BSDF")
    assert not plain["is_emissive"]
    assert not plain["maybe_transparent"]
    assert plain["lobes"] == 1 | 4
    leaf = traits(Node("ShaderNodeBsdfPrincipled", "p", {"Alpha": 0.5}), "BSDF")
    assert leaf["maybe_transparent"]
    dark = traits(
        Node(
            "ShaderNodeBsdfPrincipled",
            "p",
            {"Emission Strength": 1.0, "Emission Color": (0, 0, 0, 1)},
        ),
        "BSDF",
    )
    assert not dark["is_emissive"]
    lamp = traits(Node("ShaderNodeBsdfPrincipled", "p", {"Emission Strength": 2.0}), "BSDF")
    assert lamp["is_emissive"]
    assert lamp["average_emission"] == pytest.approx((2.0, 2.0, 2.0))


def test_view_dependence_is_known() -> None:
    for kind, output in (
        ("ShaderNodeFresnel", "Fac"),
        ("ShaderNodeLightPath", "Ray Length"),
        ("ShaderNodeLayerWeight", "Facing"),
    ):
        traits = probe.compile_graph(Graph([Node(kind, "n")], Link(0, output))).traits
        assert traits["view_dependent"]
        assert traits["emission_view_dependent"]
        assert not traits["emission_constant"]
    traits = probe.compile_graph(Graph([Node("ShaderNodeTexNoise", "n")], Link(0, "Fac"))).traits
    assert not traits["view_dependent"]


def test_socket_types_convert_as_in_cycles() -> None:
    color = Node("ShaderNodeCombineColor", "c", {"Red": 1.0, "Green": 2.0, "Blue": 4.0})
    vector = Node("ShaderNodeCombineXYZ", "v", {"X": 1.0, "Y": 2.0, "Z": 4.0})
    double = Node("ShaderNodeMath", "m", {"Value": Link(0, "Color"), "Value_001": 0.0})
    grey = 0.2126390059 * 1 + 0.7151686788 * 2 + 0.0721923154 * 4
    assert emission_of([color, double], Link(1, "Value")) == pytest.approx((grey,) * 3, rel=1e-5)
    double = Node("ShaderNodeMath", "m", {"Value": Link(0, "Vector"), "Value_001": 0.0})
    assert emission_of([vector, double], Link(1, "Value")) == pytest.approx((7 / 3,) * 3, rel=1e-5)


def test_average_emission_of_a_textured_light() -> None:
    pixels = np.zeros((2, 2, 3), np.float32)
    pixels[..., 0], pixels[..., 1], pixels[0, 0, 2] = 0.5, 1.0, 2.0
    graph = Graph(
        [
            Node("ShaderNodeTexImage", "tex", {}, {"image": 0}),
            Node("ShaderNodeEmission", "e", {"Color": Link(0, "Color"), "Strength": 3.0}),
        ],
        Link(1, "Emission"),
    )
    material = probe.compile_graph(graph, "m", [Image("i", pixels, "linear")])
    assert material.traits["average_emission"] == pytest.approx((1.5, 3.0, 1.5), rel=1e-5)
    assert not material.traits["emission_constant"]


@pytest.mark.parametrize(
    ("kind", "output", "params"),
    [
        *[("TexNoise", "Color", {"noise_dimensions": d}) for d in ("1D", "2D", "3D", "4D")],
        *[
            ("TexVoronoi", "Distance", {"feature": f})
            for f in ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE")
        ],
        ("TexVoronoi", "Color", {}),
        ("TexChecker", "Color", {}),
        ("TexBrick", "Color", {}),
        ("TexMagic", "Color", {}),
        ("TexGradient", "Fac", {"gradient_type": "RADIAL"}),
        ("TexImage", "Color", {"image": 0}),
        ("TexImage", "Color", {"image": 0, "interpolation": "Cubic", "extension": "MIRROR"}),
    ],
)
@pytest.mark.parametrize("scale", [1e-30, 1e9, 1e30, float("inf"), float("nan")])
def test_textures_stay_finite_at_the_extremes(
    kind: str, output: str, params: dict[str, Any], scale: float
) -> None:
    nodes = [
        Node("ShaderNodeNewGeometry", "g"),
        Node(
            "ShaderNodeVectorMath",
            "scale",
            {"Vector": Link(0, "Position"), "Scale": scale},
            {"operation": "SCALE"},
        ),
        Node(f"ShaderNode{kind}", "texture", {"Vector": Link(1, "Vector")}, params),
    ]
    pixels = np.linspace(0, 255, 4 * 5 * 3).astype(np.uint8).reshape(4, 5, 3)
    image = Image("i", pixels)
    material = probe.compile_graph(Graph(nodes, Link(2, output)), "m", [image])
    values = material.emission(*points(50))
    assert np.isfinite(values).all()
    assert np.abs(values).max() < 100
