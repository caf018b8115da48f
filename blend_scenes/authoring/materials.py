"""Short builders of ordinary node trees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import bpy

# A constant, or the socket (bpy.types.NodeSocket) to link; Blender's types are unknown to mypy.
Value: TypeAlias = Any


class Nodes:
    """A node tree with one call per node: `nodes.add(kind, {input: value or socket}, setting=...)`.

    Inputs are given by name or, where a node has several of one name, by index. A color of three
    components is completed with alpha 1.
    """

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        self.tree = tree
        self._count = 0

    def add(
        self, kind: str, inputs: Mapping[str | int, Value] | None = None, **settings: object
    ) -> bpy.types.Node:
        """Adds the node `ShaderNode<kind>` (or `Node<kind>` where there is none by that name)."""
        prefix = "" if kind.startswith("Node") else "ShaderNode"
        node = self.tree.nodes.new(prefix + kind)
        node.location = (220 * (self._count % 8) - 1600, 320 - 300 * (self._count // 8))
        self._count += 1
        for setting, constant in settings.items():
            setattr(node, setting, constant)
        for key, value in (inputs or {}).items():
            self.set_input(node, key, value)
        return node

    def set_input(self, node: bpy.types.Node, key: str | int, value: Value) -> None:
        """Links a socket to an input, or sets the input's constant."""
        target = node.inputs[key]
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, target)
        elif isinstance(value, int | float):
            target.default_value = value
        else:
            components = tuple(value)
            if target.type == "RGBA" and len(components) == 3:
                components = (*components, 1.0)
            target.default_value = components

    def ramp(
        self,
        factor: Value,
        stops: Sequence[tuple[float, Sequence[float]]],
        interpolation: str = "LINEAR",
    ) -> bpy.types.NodeSocket:
        """Adds a Color Ramp with the given (position, color) stops; returns its color."""
        node = self.add("ValToRGB", {"Fac": factor})
        node.color_ramp.interpolation = interpolation
        elements = node.color_ramp.elements
        while len(elements) < len(stops):
            elements.new(1.0)
        for element, (position, color) in zip(elements, stops, strict=True):
            element.position = position
            element.color = (*color, 1.0) if len(color) == 3 else color
        return node.outputs["Color"]

    def mix(self, factor: Value, a: Value, b: Value, blend: str = "MIX") -> bpy.types.NodeSocket:
        """Adds a Mix node for colors; returns the result."""
        node = self.add("Mix", data_type="RGBA", blend_type=blend)
        names = {socket.identifier: index for index, socket in enumerate(node.inputs)}
        self.set_input(node, names["Factor_Float"], factor)
        self.set_input(node, names["A_Color"], a)
        self.set_input(node, names["B_Color"], b)
        return next(s for s in node.outputs if s.identifier == "Result_Color")

    def math(self, operation: str, a: Value, b: Value = 0.0) -> bpy.types.NodeSocket:
        """Adds a Math node; returns its value."""
        return self.add("Math", {0: a, 1: b}, operation=operation).outputs["Value"]

    def coordinates(
        self, kind: str, scale: Sequence[float] = (1, 1, 1), rotation: Sequence[float] = (0, 0, 0)
    ) -> bpy.types.NodeSocket:
        """Adds Texture Coordinate (`kind`: Object, UV, Generated, ...) and Mapping; returns it."""
        source = self.add("TexCoord").outputs[kind]
        mapping = self.add("Mapping", {"Vector": source, "Scale": scale, "Rotation": rotation})
        return mapping.outputs["Vector"]

    def output(self, surface: bpy.types.NodeSocket) -> None:
        """Ends the tree in a Material Output."""
        self.add("OutputMaterial", {"Surface": surface})


def new_material(name: str) -> tuple[bpy.types.Material, Nodes]:
    """Makes a material with an empty node tree."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    return material, Nodes(material.node_tree)


def closure(
    name: str, kind: str, inputs: Mapping[str | int, Value], **settings: object
) -> bpy.types.Material:
    """Makes a material of one closure node, for example `Bsdf Diffuse` as kind `BsdfDiffuse`."""
    material, nodes = new_material(name)
    nodes.output(nodes.add(kind, inputs, **settings).outputs[0])
    return material


def diffuse(name: str, color: Sequence[float]) -> bpy.types.Material:
    """A Lambertian surface of reflectance `color`."""
    return closure(name, "BsdfDiffuse", {"Color": color})


def emitter(name: str, color: Sequence[float], strength: float) -> bpy.types.Material:
    """A surface of radiance `color * strength` on both its sides."""
    return closure(name, "Emission", {"Color": color, "Strength": strength})


def glass(
    name: str, ior: float = 1.5, roughness: float = 0.0, color: Sequence[float] = (1, 1, 1)
) -> bpy.types.Material:
    """A dielectric; smooth at roughness 0."""
    return closure(name, "BsdfGlass", {"Color": color, "Roughness": roughness, "IOR": ior})


def metal(name: str, color: Sequence[float], roughness: float) -> bpy.types.Material:
    """A conductor by the Principled node; `color` is its reflectance at normal incidence."""
    return principled(name, color, roughness, {"Metallic": 1.0})


def principled(
    name: str,
    color: Sequence[float],
    roughness: float,
    inputs: Mapping[str | int, Value] | None = None,
) -> bpy.types.Material:
    """The Principled node with constant inputs."""
    return closure(
        name, "BsdfPrincipled", {"Base Color": color, "Roughness": roughness, **(inputs or {})}
    )
