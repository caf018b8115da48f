"""The world."""

from __future__ import annotations

import bpy
from engine_core.description import Graph, Link, Node, Visibility, World

from ..materials.report_types import Warn
from ..materials.translate import ImageIndex, translate


def read_world(world: bpy.types.World, image_index: ImageIndex, warn: Warn) -> World:
    """Reads an evaluated world; without nodes it has one colour everywhere."""
    tree = world.node_tree
    if tree is not None and uses_nodes(world):
        graph = translate(world, tree, f'world "{world.name}"', image_index, warn)
    else:
        color = (*(float(x) for x in world.color), 1.0)
        background = Node("ShaderNodeBackground", "color", {"Color": color, "Strength": 1.0})
        graph = Graph([background], Link(0, "Background"))
    return World(graph, _visibility(world))


def uses_nodes(owner: bpy.types.Material | bpy.types.World | bpy.types.Light) -> bool:
    """Whether the node tree counts. From 5.0 on it always does."""
    return bpy.app.version >= (5, 0, 0) or bool(owner.use_nodes)


def _visibility(world: bpy.types.World) -> int:
    """Which rays see it: options of Cycles' that exist only while that add-on is enabled."""
    options = getattr(world, "cycles_visibility", None)
    if options is None:
        return int(Visibility.ALL)
    visibility = int(Visibility.SHADOW)
    for name in ("camera", "diffuse", "glossy", "transmission"):
        if getattr(options, name):
            visibility |= Visibility[name.upper()]
    return visibility
