"""Which attributes of a mesh a material reads."""

from __future__ import annotations

from typing import NamedTuple

from engine_core.description import Graph, Link


class AttributeRead(NamedTuple):
    """`kind` is uv, tangent, color or attribute; an empty `name` is the mesh's active one."""

    kind: str
    name: str


def attribute_reads(graph: Graph) -> frozenset[AttributeRead]:
    """Returns what the nodes of `graph` read of the mesh they shade."""
    linked = {
        (value.node, value.output)
        for node in graph.nodes
        for value in node.inputs.values()
        if isinstance(value, Link)
    }
    reads: set[AttributeRead] = set()
    for index, node in enumerate(graph.nodes):
        params = node.params
        uv_map = str(params.get("uv_map", ""))
        match node.kind:
            case "ShaderNodeUVMap":
                reads.add(AttributeRead("uv", uv_map))
            case "ShaderNodeTexCoord":
                if (index, "UV") in linked:
                    reads.add(AttributeRead("uv", ""))
            case "ShaderNodeTexImage":
                if "Vector" not in node.inputs:
                    reads.add(AttributeRead("uv", ""))
            case "ShaderNodeNormalMap":
                if params.get("space", "TANGENT") == "TANGENT":
                    reads |= {AttributeRead("uv", uv_map), AttributeRead("tangent", uv_map)}
            case "ShaderNodeTangent":
                if params.get("direction_type") == "UV_MAP":
                    reads |= {AttributeRead("uv", uv_map), AttributeRead("tangent", uv_map)}
            case "ShaderNodeVertexColor":
                reads.add(AttributeRead("color", str(params.get("layer_name", ""))))
            case "ShaderNodeAttribute":
                name = str(params.get("attribute_name", ""))
                if name and params.get("attribute_type", "GEOMETRY") == "GEOMETRY":
                    reads.add(AttributeRead("attribute", name))
    return frozenset(reads)
