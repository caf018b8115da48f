"""Following links backwards through reroutes, muted nodes and nested groups."""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy


@dataclass(eq=False)
class Frame:
    """One use of a node tree: `group` is the group node that uses it in the frame `parent`."""

    tree: bpy.types.NodeTree
    parent: Frame | None = None
    group: bpy.types.Node | None = None
    children: dict[int, Frame] = field(default_factory=dict)

    def child(self, group: bpy.types.Node) -> Frame:
        """The frame of the tree inside `group`, the same one at every call."""
        key = group.as_pointer()
        if key not in self.children:
            self.children[key] = Frame(group.node_tree, self, group)
        return self.children[key]

    def contains(self, tree: bpy.types.NodeTree) -> bool:
        """Whether `tree` is this frame's tree or one of those around it."""
        frame: Frame | None = self
        while frame is not None:
            if frame.tree == tree:
                return True
            frame = frame.parent
        return False


@dataclass
class Source:
    """Where an input's value comes from.

    Either `node` (in `frame`) and its `socket`; or the constant of the input `socket` with `node`
    None; or nothing (`socket` None): then the input's own value counts. `types` are the socket
    types that the value takes on its way, from the source on.
    """

    socket: bpy.types.NodeSocket | None
    node: bpy.types.Node | None = None
    frame: Frame | None = None
    types: list[str] = field(default_factory=list)


NOTHING = Source(None)


class LinkIndex:
    """The links of node trees by the socket they end in: Blender's own look-up is linear."""

    def __init__(self) -> None:
        self._incoming: dict[int, dict[int, bpy.types.NodeLink]] = {}
        self._outputs: dict[int, bpy.types.Node | None] = {}

    def incoming(
        self, tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket
    ) -> bpy.types.NodeLink | None:
        """The valid, unmuted link that ends in `socket`, if there is one."""
        links = self._incoming.get(tree.as_pointer())
        if links is None:
            links = {
                link.to_socket.as_pointer(): link
                for link in tree.links
                if link.is_valid and not link.is_muted
            }
            self._incoming[tree.as_pointer()] = links
        return links.get(socket.as_pointer())

    def group_output(self, tree: bpy.types.NodeTree) -> bpy.types.Node | None:
        """The active Group Output of a group's tree."""
        key = tree.as_pointer()
        if key not in self._outputs:
            found = [node for node in tree.nodes if node.bl_idname == "NodeGroupOutput"]
            active = [node for node in found if node.is_active_output]
            self._outputs[key] = (active or found or [None])[0]
        return self._outputs[key]

    def resolve(self, frame: Frame, socket: bpy.types.NodeSocket) -> Source:
        """Finds where the input `socket` of a node in `frame` takes its value from."""
        types = [socket.type]
        seen: set[tuple[int, int]] = set()
        start = True
        while True:
            place = (id(frame), socket.as_pointer())
            link = None if place in seen else self.incoming(frame.tree, socket)
            seen.add(place)
            if link is None:
                if start or _is_plain(socket):
                    return NOTHING
                return Source(socket, types=types[::-1])
            start = False
            node, output = link.from_node, link.from_socket
            types.append(output.type)
            if node.mute:
                inner = next((x for x in node.internal_links if x.to_socket == output), None)
                if inner is None:
                    return NOTHING
                socket = inner.from_socket
            elif node.bl_idname == "NodeReroute":
                socket = node.inputs[0]
            elif node.bl_idname == "NodeGroupInput":
                if frame.parent is None or frame.group is None:
                    return NOTHING
                outer = by_identifier(frame.group.inputs, output.identifier)
                if outer is None:
                    return NOTHING
                frame, socket = frame.parent, outer
            elif is_group(node):
                inside = self._enter(frame, node, output)
                if inside is None:
                    return NOTHING
                frame, socket = inside
            else:
                return Source(output, node, frame, types[::-1])
            types.append(socket.type)

    def _enter(
        self, frame: Frame, node: bpy.types.Node, output: bpy.types.NodeSocket
    ) -> tuple[Frame, bpy.types.NodeSocket] | None:
        """The Group Output's input that stands behind `output` of the group `node`."""
        tree = node.node_tree
        if tree is None or frame.contains(tree):
            return None
        group_output = self.group_output(tree)
        if group_output is None:
            return None
        socket = by_identifier(group_output.inputs, output.identifier)
        return None if socket is None else (frame.child(node), socket)


def is_group(node: bpy.types.Node) -> bool:
    return bool(node.type == "GROUP") and hasattr(node, "node_tree")


def by_identifier(
    sockets: bpy.types.bpy_prop_collection, identifier: str
) -> bpy.types.NodeSocket | None:
    return next((socket for socket in sockets if socket.identifier == identifier), None)


def _is_plain(socket: bpy.types.NodeSocket) -> bool:
    """Whether an unlinked socket passes no value on: a reroute, or one of shaders."""
    return socket.node.bl_idname == "NodeReroute" or not hasattr(socket, "default_value")
