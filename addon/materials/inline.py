"""Trees with nodes that are no shader nodes (repeat zones, closures, bundles, menus).

Blender 5.2 resolves them itself, by `InlineShaderNodes`. Older versions have no such nodes.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

# Nodes that are no shader nodes and that the translation resolves itself.
_STRUCTURE = {"NodeFrame", "NodeReroute", "NodeGroupInput", "NodeGroupOutput", "NodeUndefined", ""}


@contextmanager
def flattened(
    owner: bpy.types.Material | bpy.types.World | bpy.types.Light,
    tree: bpy.types.ShaderNodeTree,
) -> Iterator[bpy.types.ShaderNodeTree]:
    """Yields `tree`, or what Blender makes of it where it holds other than shader nodes."""
    inline = getattr(bpy.types, "InlineShaderNodes", None)
    if inline is None or not _needs_inlining(tree):
        yield tree
        return
    if isinstance(owner, bpy.types.Material):
        nodes = inline.from_material(owner)
    elif isinstance(owner, bpy.types.World):
        nodes = inline.from_world(owner)
    else:
        nodes = inline.from_light(owner)
    yield nodes.node_tree


def _needs_inlining(tree: bpy.types.ShaderNodeTree) -> bool:
    seen: set[int] = set()
    trees = [tree]
    while trees:
        current = trees.pop()
        if current.as_pointer() in seen:
            continue
        seen.add(current.as_pointer())
        for node in current.nodes:
            inner = getattr(node, "node_tree", None)
            if inner is not None:
                trees.append(inner)
            elif not node.bl_idname.startswith("ShaderNode") and node.bl_idname not in _STRUCTURE:
                return True
    return False
