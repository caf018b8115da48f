"""Meshes: arrays, normals, attributes, and what is wrong with them."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest
from engine_core.description import Domain


def _values(mesh: Any, name: str) -> Any:
    return next(item.data for item in mesh.attributes if item.name == name)


def _reading_material(make: Any, kind: str, output: str, **settings: Any) -> Any:
    """A material whose diffuse colour is a node's output."""
    material = make.material("Reads")
    nodes, links = material.node_tree.nodes, material.node_tree.links
    source = nodes.new(kind)
    for key, value in settings.items():
        setattr(source, key, value)
    surface = nodes.new("ShaderNodeBsdfDiffuse")
    result = nodes.new("ShaderNodeOutputMaterial")
    links.new(source.outputs[output], surface.inputs["Color"])
    links.new(surface.outputs[0], result.inputs["Surface"])
    return material


def test_polygons_arrive_as_they_are(make: Any, export: Any) -> None:
    mesh = bpy.data.meshes.new("House")
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 1.5, 0)]
    mesh.from_pydata(points, [], [(0, 1, 2, 4, 3), (0, 3, 4)])
    make.object("House", mesh)
    result = export()[0].meshes[0]
    np.testing.assert_array_equal(result.positions, np.array(points, np.float32))
    assert result.corner_vertices.tolist() == [0, 1, 2, 4, 3, 0, 3, 4]
    assert result.face_offsets.tolist() == [0, 5, 8]
    assert result.face_materials is None
    assert result.attributes == []


def test_flat_smooth_and_mixed_normals(make: Any, export: Any) -> None:
    mesh = bpy.data.meshes.new("Roof")
    mesh.from_pydata(
        [(0, 0, 0), (0, 1, 0), (1, 0, 1), (1, 1, 1), (-1, 0, 1), (-1, 1, 1)],
        [],
        [(0, 2, 3, 1), (0, 1, 5, 4)],
    )
    make.object("Roof", mesh)
    flat = export()[0].meshes[0]
    assert (flat.normal_domain, flat.normals) == (Domain.FACE, None)

    mesh.polygons.foreach_set("use_smooth", [True, True])
    mesh.update()
    smooth = export()[0].meshes[0]
    assert smooth.normal_domain == Domain.POINT
    np.testing.assert_allclose(np.abs(smooth.normals[0]), (0, 0, 1), atol=1e-6)

    mesh.polygons.foreach_set("use_smooth", [True, False])
    mesh.update()
    mixed = export()[0].meshes[0]
    assert mixed.normal_domain == Domain.CORNER
    assert mixed.normals.shape == (8, 3)
    np.testing.assert_allclose(np.linalg.norm(mixed.normals, axis=1), 1.0, atol=1e-6)


def test_slots_beyond_the_materials_are_clamped(make: Any, export: Any) -> None:
    mesh = bpy.data.meshes.new("Strip")
    mesh.from_pydata(
        [(x, y, 0) for x in range(4) for y in range(2)],
        [],
        [(2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1) for i in range(3)],
    )
    mesh.materials.append(make.material("A"))
    mesh.materials.append(make.material("B"))
    mesh.polygons.foreach_set("material_index", [1, 7, 0])
    make.object("Strip", mesh)
    assert export()[0].meshes[0].face_materials.tolist() == [1, 1, 0]


def test_vertices_that_are_not_finite_drop_the_mesh(make: Any, export: Any) -> None:
    make.object("Good", make.quad("Good"))
    bad = make.quad("Bad")
    bad.vertices[2].co.y = float("nan")
    make.object("Broken", bad)
    description, messages = export()
    assert [mesh.name for mesh in description.meshes] == ["Good"]
    assert len(description.instances.mesh) == 1
    assert messages == [
        'object "Broken": its mesh has vertices that are not finite; it is left out'
    ]


@pytest.mark.parametrize("index", [4, -1, 2**31 - 1])
def test_vertices_that_do_not_exist_drop_the_mesh(make: Any, export: Any, index: int) -> None:
    make.object("Good", make.quad("Good"))
    bad = make.quad("Bad")
    bad.attributes[".corner_vert"].data[2].value = index
    make.object("Broken", bad)
    description, messages = export()
    assert [mesh.name for mesh in description.meshes] == ["Good"]
    assert messages == [
        'object "Broken": its mesh has faces of vertices that do not exist; it is left out'
    ]


def test_empty_and_faceless_meshes_are_nothing(make: Any, export: Any) -> None:
    make.object("Empty", bpy.data.meshes.new("Empty"))
    wire = bpy.data.meshes.new("Wire")
    wire.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    make.object("Wire", wire)
    description, messages = export()
    assert (description.meshes, messages) == ([], [])
    assert description.instances.transform.shape == (0, 3, 4)


def test_only_uv_maps_that_are_read(make: Any, export: Any) -> None:
    mesh = make.quad("Quad", uv=True)
    mesh.uv_layers.new(name="Other")
    make.object("Quad", mesh)
    assert export()[0].meshes[0].attributes == []
    mesh.materials.append(_reading_material(make, "ShaderNodeUVMap", "UV", uv_map="Map"))
    result = export()[0].meshes[0]
    assert [item.name for item in result.attributes] == ["Map"]
    assert result.attributes[0].domain == Domain.CORNER
    np.testing.assert_array_equal(_values(result, "Map"), [(0, 0), (1, 0), (1, 1), (0, 1)])


def test_the_active_uv_map_is_the_one_that_renders(make: Any, export: Any) -> None:
    mesh = make.quad("Quad", uv=True)
    mesh.uv_layers.new(name="Other").active_render = True
    mesh.materials.append(_reading_material(make, "ShaderNodeTexCoord", "UV"))
    make.object("Quad", mesh)
    result = export()[0].meshes[0]
    assert result.active_uv == "Other"
    assert [item.name for item in result.attributes] == ["Other"]


@pytest.mark.parametrize("kind", ["FLOAT_COLOR", "BYTE_COLOR"])
@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
def test_colours_are_linear(make: Any, export: Any, kind: str, domain: str) -> None:
    mesh = make.quad("Quad")
    layer = mesh.color_attributes.new("Paint", kind, domain)
    layer.data.foreach_set("color", [0.25, 0.5, 1.0, 0.5] * 4)
    mesh.materials.append(
        _reading_material(make, "ShaderNodeVertexColor", "Color", layer_name="Paint")
    )
    make.object("Quad", mesh)
    result = export()[0].meshes[0]
    step = 0.5 / 255 if kind == "BYTE_COLOR" else 1e-7
    np.testing.assert_allclose(_values(result, "Paint"), [(0.25, 0.5, 1.0, 0.5)] * 4, atol=3 * step)
    assert result.attributes[0].domain == Domain[domain]


def test_nodes_that_name_no_colour_read_the_active_one(make: Any, export: Any) -> None:
    mesh = make.quad("Quad")
    mesh.color_attributes.new("First", "FLOAT_COLOR", "POINT")
    second = mesh.color_attributes.new("Second", "FLOAT_COLOR", "POINT")
    second.data.foreach_set("color", [0.0, 1.0, 0.0, 1.0] * 4)
    mesh.color_attributes.render_color_index = 1
    mesh.materials.append(_reading_material(make, "ShaderNodeVertexColor", "Color"))
    make.object("Quad", mesh)
    result = export()[0].meshes[0]
    assert result.active_color == "Second"
    assert [item.name for item in result.attributes] == ["Second"]
    np.testing.assert_array_equal(_values(result, "Second"), [(0, 1, 0, 1)] * 4)


@pytest.mark.parametrize(
    ("kind", "member", "domain", "value", "channels"),
    [
        ("FLOAT", "value", "FACE", 1.5, 1),
        ("INT", "value", "POINT", 7, 1),
        ("BOOLEAN", "value", "CORNER", True, 1),
        ("FLOAT2", "vector", "POINT", (1, 2), 2),
        ("FLOAT_VECTOR", "vector", "FACE", (1, 2, 3), 3),
    ],
)
def test_generic_attributes(
    make: Any, export: Any, kind: str, member: str, domain: str, value: Any, channels: int
) -> None:
    mesh = make.quad("Quad")
    data = mesh.attributes.new("Mine", kind, domain).data
    for item in data:
        setattr(item, member, value)
    mesh.materials.append(
        _reading_material(make, "ShaderNodeAttribute", "Color", attribute_name="Mine")
    )
    make.object("Quad", mesh)
    result = export()[0].meshes[0].attributes[0]
    assert (result.name, result.domain) == ("Mine", Domain[domain])
    np.testing.assert_array_equal(result.data, np.full((len(data), channels), value, np.float32))


def test_attributes_on_edges_are_named(make: Any, export: Any) -> None:
    mesh = make.quad("Quad")
    mesh.attributes.new("Crease", "FLOAT", "EDGE")
    mesh.materials.append(
        _reading_material(make, "ShaderNodeAttribute", "Fac", attribute_name="Crease")
    )
    make.object("Quad", mesh)
    description, messages = export()
    assert description.meshes[0].attributes == []
    assert messages == [
        'object "Quad": attribute "Crease" (float on edges) is not supported; materials read 0'
    ]


def test_tangents_of_a_plane(make: Any, export: Any) -> None:
    mesh = make.quad("Quad", uv=True)
    mesh.materials.append(_reading_material(make, "ShaderNodeNormalMap", "Normal", uv_map="Map"))
    make.object("Quad", mesh)
    result = export()[0].meshes[0]
    np.testing.assert_allclose(_values(result, "tangent:Map"), [(1, 0, 0, 1)] * 4, atol=1e-6)
    assert {item.name for item in result.attributes} == {"Map", "tangent:Map"}


def test_tangents_of_large_faces_agree_with_mikktspace(make: Any) -> None:
    """The construction for faces of any size, on quads, where Blender's own can be had."""
    from addon.materials.reads import AttributeRead
    from addon.sync.mesh import read_mesh
    from addon.sync.report import Report
    from addon.sync.tangents import _weighted_tangents, tangents

    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
    mesh = bpy.context.object.data
    quads = [tuple(p.vertices) for p in mesh.polygons if len(p.vertices) == 4]
    smooth = bpy.data.meshes.new("Quads")
    smooth.from_pydata([tuple(v.co) for v in mesh.vertices], [], quads)
    layer = smooth.uv_layers.new(name="Map")
    kept = [i for p in mesh.polygons if len(p.vertices) == 4 for i in p.loop_indices]
    for target, source in enumerate(kept):
        layer.data[target].uv = mesh.uv_layers[0].data[source].uv
    smooth.polygons.foreach_set("use_smooth", [True] * len(quads))
    result = read_mesh(smooth, "Quads", frozenset({AttributeRead("uv", "Map")}), 1, Report())
    assert result is not None
    expected, found = tangents(smooth, result, "Map"), _weighted_tangents(smooth, result, "Map")
    np.testing.assert_array_equal(found[:, 3], expected[:, 3])
    assert np.einsum("ij,ij->i", found[:, :3], expected[:, :3]).min() > 0.999


def test_tangents_of_a_pentagon(make: Any, export: Any) -> None:
    mesh = bpy.data.meshes.new("Pentagon")
    angles = np.arange(5) * 2 * np.pi / 5
    points = np.stack((np.cos(angles), np.sin(angles), 0 * angles), axis=1)
    mesh.from_pydata(points.tolist(), [], [tuple(range(5))])
    layer = mesh.uv_layers.new(name="Map")
    layer.data.foreach_set("uv", points[:, 1::-1].astype(np.float32).reshape(-1))  # mirrored
    mesh.materials.append(_reading_material(make, "ShaderNodeNormalMap", "Normal", uv_map="Map"))
    make.object("Pentagon", mesh)
    np.testing.assert_allclose(
        _values(export()[0].meshes[0], "tangent:Map"), [(0, 1, 0, -1)] * 5, atol=1e-6
    )


def test_texture_space_is_the_bounding_box(make: Any, export: Any) -> None:
    make.object("Quad", make.quad("Quad"))
    result = export()[0].meshes[0]
    assert result.texture_space_min[:2] == pytest.approx((0, 0))
    assert result.texture_space_max[:2] == pytest.approx((2, 1))


def test_modifiers_are_applied(make: Any, export: Any) -> None:
    item = make.object("Quad", make.quad("Quad"))
    item.modifiers.new("Array", "ARRAY").count = 3
    assert len(export()[0].meshes[0].face_offsets) == 4


@pytest.mark.parametrize("kind", ["FONT", "CURVE", "SURFACE", "META"])
def test_other_geometry_arrives_as_meshes(make: Any, export: Any, kind: str) -> None:
    if kind == "META":
        data = bpy.data.metaballs.new("Data")
        data.elements.new()
    else:
        data = bpy.data.curves.new("Data", kind)
    if kind == "FONT":
        data.body = "V"
    elif kind == "CURVE":
        data.bevel_depth = 0.1
        spline = data.splines.new("POLY")
        spline.points.add(1)
        spline.points[1].co = (1, 0, 0, 1)
    elif kind == "SURFACE":
        bpy.ops.surface.primitive_nurbs_surface_sphere_add()
        data = bpy.context.object.data
        bpy.data.objects.remove(bpy.context.object)
    make.object("Thing", data)
    description, messages = export()
    assert (len(description.meshes), messages) == (1, [])
    assert len(description.instances.mesh) == 1
    assert len(description.meshes[0].positions) > 3
