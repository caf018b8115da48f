# mypy: disallow-subclassing-any=False
"""Denoising, off unless it is asked for: by Blender's own Open Image Denoise, in the compositor.

The engine renders what is true within its error bar; a denoised picture is a guess that looks
smooth, and no error bar tells how far it is off. So it is not the engine's doing: a node between
the render and the output does it, where it can be seen, set and taken out.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context

NODE = "Vernier Denoise"


def set_up(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> bool:
    """Puts a Denoise node behind the layer's picture, guided by its albedo and normals.

    What the picture went to takes the denoised one. False where the node is there already.
    """
    layer.vernier.use_pass_denoising = True
    layer.update_render_passes()
    scene.render.use_compositing = True
    tree = _tree(scene)
    if NODE in tree.nodes:
        return False
    source = _layers_node(tree, scene, layer)
    node = tree.nodes.new("CompositorNodeDenoise")
    node.name = node.label = NODE
    node.location = (source.location.x + 320, source.location.y)
    targets = [link.to_socket for link in source.outputs["Image"].links]
    for target in targets:
        tree.links.new(node.outputs["Image"], target)
    if not targets:
        tree.links.new(node.outputs["Image"], _output(tree).inputs[0])
    tree.links.new(source.outputs["Image"], node.inputs["Image"])
    for guide in ("Albedo", "Normal"):
        tree.links.new(source.outputs[f"Denoising {guide}"], node.inputs[guide])
    return True


def _tree(scene: bpy.types.Scene) -> Any:
    """The scene's compositor; made where there is none."""
    if not hasattr(scene, "compositing_node_group"):  # Blender 4.5
        scene.use_nodes = True
        return scene.node_tree
    if scene.compositing_node_group is None:
        scene.compositing_node_group = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
    return scene.compositing_node_group


def _layers_node(tree: Any, scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> Any:
    for node in tree.nodes:
        if node.bl_idname == "CompositorNodeRLayers" and node.layer == layer.name:
            return node
    node = tree.nodes.new("CompositorNodeRLayers")
    node.scene, node.layer = scene, layer.name
    return node


def _output(tree: Any) -> Any:
    """The node whose first input takes the finished picture."""
    kind = "CompositorNodeComposite"
    if bpy.app.version >= (5, 0, 0):
        kind = "NodeGroupOutput"
        sockets = tree.interface.items_tree
        if not any(s.item_type == "SOCKET" and s.in_out == "OUTPUT" for s in sockets):
            tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    found = [node for node in tree.nodes if node.bl_idname == kind]
    return found[0] if found else tree.nodes.new(kind)


class VERNIER_OT_denoise(bpy.types.Operator):  # noqa: N801 - Blender's naming rule
    """Denoise the picture in the compositor, by Open Image Denoise with albedo and normals. \
The error bar tells nothing of what that changes"""

    bl_idname = "render.vernier_denoise"
    bl_label = "Denoise in the Compositor"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    def execute(self, context: Context) -> set[str]:
        if not set_up(context.scene, context.view_layer):
            self.report({"INFO"}, f"The compositor has its node “{NODE}” already")
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(VERNIER_OT_denoise)


def unregister() -> None:
    bpy.utils.unregister_class(VERNIER_OT_denoise)
