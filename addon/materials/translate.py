"""Node trees of materials, worlds and lights to flat graphs.

The tree is walked from its active output, so what nothing reads is never looked at. The walk keeps
its own stack: neither long chains nor deep nesting exhaust Python's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import numpy as np
from engine_core.description import Graph, InputValue, Link, Node, ParamValue

from . import registry
from .inline import flattened
from .report_types import Warn
from .tree import Frame, LinkIndex, Source
from .values import Constant, convert_along, family, socket_constant

# Gives the index of an image in the description's list.
ImageIndex = Callable[[bpy.types.Image, bpy.types.ImageUser], int]


def translate(
    owner: bpy.types.Material | bpy.types.World | bpy.types.Light,
    tree: bpy.types.ShaderNodeTree,
    name: str,
    image_index: ImageIndex,
    warn: Warn,
) -> Graph:
    """Flattens the shader node tree of `owner`; `name` is what messages call it."""
    with flattened(owner, tree) as plain:
        return _Translation(plain, name, image_index, warn).run()


@dataclass
class _Translation:
    tree: bpy.types.ShaderNodeTree
    name: str
    image_index: ImageIndex
    warn: Warn
    graph: Graph = field(default_factory=Graph)
    links: LinkIndex = field(default_factory=LinkIndex)
    numbers: dict[tuple[int, int], int] = field(default_factory=dict)
    pending: list[tuple[Frame, bpy.types.Node, int]] = field(default_factory=list)

    def run(self) -> Graph:
        output = self.tree.get_output_node("CYCLES")
        if output is None:
            return self.graph
        root = Frame(self.tree)
        surface = output.inputs.get("Surface")
        if surface is not None:
            value = self._value(self.links.resolve(root, surface))
            self.graph.surface = value if isinstance(value, Link) else None
        while self.pending:
            frame, node, number = self.pending.pop()
            self._fill(frame, node, self.graph.nodes[number])
        self._report_unread(root, output)
        _cut_cycles(self.graph, self.name, self.warn)
        return self.graph

    def _report_unread(self, root: Frame, output: bpy.types.Node) -> None:
        """Names the outputs of the tree that are not rendered."""
        for socket in output.inputs:
            if socket.identifier in ("Volume", "Displacement"):
                source = self.links.resolve(root, socket)
                if source.node is not None:
                    self.warn(
                        f'{self.name}: {socket.identifier.lower()} (node "{source.node.name}") '
                        "is not supported; it is left out"
                    )

    def _number(self, frame: Frame, node: bpy.types.Node) -> int:
        """The number of a node in one use of its tree; a new one is queued to be filled in."""
        key = (id(frame), node.as_pointer())
        if key not in self.numbers:
            self.numbers[key] = len(self.graph.nodes)
            self.graph.nodes.append(Node(node.bl_idname, _path(frame, node)))
            self.pending.append((frame, node, self.numbers[key]))
        return self.numbers[key]

    def _fill(self, frame: Frame, node: bpy.types.Node, result: Node) -> None:
        for socket in node.inputs:
            if not socket.enabled or socket.is_unavailable:
                continue
            source = self.links.resolve(frame, socket)
            value = self._value(source)
            if value is None and not socket.hide_value:
                value = socket_constant(socket) if hasattr(socket, "default_value") else None
            if source.node is None and _is_direction(socket):
                value = None
            if value is not None:
                result.inputs[socket.identifier] = value
        result.params.update(self._params(node))

    def _value(self, source: Source) -> InputValue | None:
        """The description's form of a source; None: the reading input's own value counts."""
        if source.socket is None:
            return None
        if source.node is None or source.node.bl_idname in registry.CONSTANTS:
            constant = socket_constant(source.socket)
            if constant is None:
                return None
            return self._constant(constant, source.types)
        assert source.frame is not None
        link = Link(self._number(source.frame, source.node), source.socket.identifier)
        return self._converted(link, source.types)

    def _constant(self, value: Constant, types: list[str]) -> InputValue | None:
        if family(types[-1]) != "SHADER":
            return convert_along(value, types)
        color = convert_along(value, [*types[:-1], "RGBA"])
        return None if color is None else self._emission(color)

    def _converted(self, link: Link, types: list[str]) -> Link | None:
        """Takes a link through socket types, by nodes where a conversion loses something.

        A scalar spread over a vector or colour comes back as it was; reading a colour or a vector
        as a scalar does not. The conversion from the source's type to the reader's is the core's.
        """
        families = [family(name) for name in types]
        actual = logical = families[0]
        for number, target in enumerate(families[1:], 1):
            last = number == len(families) - 1
            if target == logical or (logical == "VALUE" and target in ("VECTOR", "RGBA")):
                continue
            if target == "SHADER":
                return self._emission(link) if logical in ("VALUE", "VECTOR", "RGBA") else None
            if logical == "SHADER" or target not in ("VALUE", "VECTOR", "RGBA"):
                return None
            if target == "VALUE" and not (last and actual == logical):
                link = self._to_scalar(link, logical)
                actual = "VALUE"
            logical = target
        return link

    def _to_scalar(self, link: Link, source: str) -> Link:
        if source == "RGBA":
            return self._add(Node("ShaderNodeRGBToBW", "conversion", {"Color": link}), "Val")
        third = 1.0 / 3.0
        node = Node(
            "ShaderNodeVectorMath",
            "conversion",
            {"Vector": link, "Vector_001": (third, third, third)},
            {"operation": "DOT_PRODUCT"},
        )
        return self._add(node, "Value")

    def _emission(self, color: InputValue) -> Link:
        """A colour that is read as a shader emits, as in Cycles."""
        inputs: dict[str, InputValue] = {"Color": color, "Strength": 1.0}
        return self._add(Node("ShaderNodeEmission", "conversion", inputs), "Emission")

    def _add(self, node: Node, output: str) -> Link:
        self.graph.nodes.append(node)
        return Link(len(self.graph.nodes) - 1, output)

    def _params(self, node: bpy.types.Node) -> dict[str, ParamValue]:
        params: dict[str, ParamValue] = {}
        for name, kind, is_array in _properties(node):
            value = getattr(node, name)
            if kind == "POINTER":
                params.update(self._pointer(node, name, value))
            elif is_array:
                params[name] = np.array(value, np.float32).reshape(-1)
            else:
                params[name] = value
        special = registry.SPECIAL.get(node.bl_idname)
        if special is not None:
            params.update(special(node))
        return params

    def _pointer(
        self, node: bpy.types.Node, name: str, value: bpy.types.bpy_struct | None
    ) -> dict[str, ParamValue]:
        if name == "image":
            return {"image": -1 if value is None else self.image_index(value, node.image_user)}
        if value is None:
            return {}
        if name in registry.POINTERS:
            return registry.POINTERS[name](value)
        self.warn(f'{self.name}: node "{node.name}": property "{name}" is not supported')
        return {}


_PROPERTIES: dict[str, list[tuple[str, str, bool]]] = {}


def _properties(node: bpy.types.Node) -> list[tuple[str, str, bool]]:
    """The node's own properties as (name, RNA type, is an array), by kind of node."""
    kind = node.bl_idname
    if kind not in _PROPERTIES:
        common = bpy.types.ShaderNode.bl_rna.properties.keys()
        _PROPERTIES[kind] = [
            (p.identifier, p.type, bool(getattr(p, "is_array", False)))
            for p in node.bl_rna.properties
            if p.identifier not in common
            and p.identifier not in registry.IGNORED
            and p.type != "COLLECTION"
            and not getattr(p, "is_enum_flag", False)
        ]
    return _PROPERTIES[kind]


def _is_direction(socket: bpy.types.NodeSocket) -> bool:
    """Whether the input is a normal or tangent, where a constant means the surface's own."""
    return socket.hide_value and socket.identifier.split()[-1] in ("Normal", "Tangent")


def _path(frame: Frame, node: bpy.types.Node) -> str:
    """The node's name, after those of the group nodes it lies in."""
    names = [node.name]
    level: Frame | None = frame
    while level is not None and level.group is not None:
        names.append(level.group.name)
        level = level.parent
    return "/".join(reversed(names))


def _cut_cycles(graph: Graph, name: str, warn: Warn) -> None:
    """Removes links that close a cycle: Blender marks those within a tree, not through groups."""
    open_nodes: set[int] = set()
    done: set[int] = set()
    for start in range(len(graph.nodes)):
        stack = [(start, False)]
        while stack:
            number, leave = stack.pop()
            if leave:
                open_nodes.discard(number)
                done.add(number)
                continue
            if number in done or number in open_nodes:
                continue
            open_nodes.add(number)
            stack.append((number, True))
            node = graph.nodes[number]
            for key, value in list(node.inputs.items()):
                if not isinstance(value, Link):
                    continue
                if value.node in open_nodes:
                    del node.inputs[key]
                    warn(f'{name}: node "{node.name}": a link to "{key}" closes a cycle; it is cut')
                elif value.node not in done:
                    stack.append((value.node, False))
