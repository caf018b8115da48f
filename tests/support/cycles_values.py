"""Values of shader nodes as Cycles computes them.

Run as a program in a process of its own: `python cycles_values.py CASES.json RESULT.npy`. Every
case is a row of faces, one face a pixel, and every face carries its own coordinate as an attribute:
so each pixel is the node's value at one exactly known point, whatever the sampling pattern.

A case is a dict: `nodes`, a list of {kind, params, inputs}, and `output` of the last one. Inputs
are numbers, lists of numbers, or [node, output] with node -1 for the coordinate.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from emitted_values import decoded, emit, socket
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]

COORDINATE = "coordinate"


def coordinates(columns: int, case: int) -> FloatArray:
    """The points of one case, (columns, 3) float32."""
    rng = np.random.default_rng(1000 + case)
    return rng.uniform(-2.5, 2.5, (columns, 3)).astype(np.float32)


def _set_special(node: Any, name: str, value: Any) -> None:
    if name == "ramp":
        elements = node.color_ramp.elements
        while len(elements) > 1:
            elements.remove(elements[-1])
        rows = [value[i : i + 5] for i in range(0, len(value), 5)]
        for number, row in enumerate(rows):
            element = elements[0] if number == 0 else elements.new(row[0])
            element.position = row[0]
            element.color = row[1:]
    elif name in ("interpolation", "color_mode", "hue_interpolation") and hasattr(
        node, "color_ramp"
    ):
        setattr(node.color_ramp, name, value)
    elif name == "direction" and node.bl_idname == "ShaderNodeNormal":
        node.outputs[0].default_value = value
    else:
        setattr(node, name, value)


def _build(material: Any, case: dict[str, Any]) -> None:
    tree = material.node_tree
    tree.nodes.clear()

    coordinate = tree.nodes.new("ShaderNodeAttribute")
    coordinate.attribute_name = COORDINATE
    built = []
    for spec in case["nodes"]:
        node = tree.nodes.new(spec["kind"])
        built.append(node)
        for name, value in spec.get("params", {}).items():
            _set_special(node, name, value)
        for name, value in spec.get("inputs", {}).items():
            target = socket(node.inputs, name)
            if isinstance(value, list) and len(value) == 2 and isinstance(value[1], str):
                number, output = value
                source = coordinate if number < 0 else built[number]
                tree.links.new(socket(source.outputs, output), target)
            else:
                target.default_value = value
    emit(tree, socket(built[-1].outputs, case["output"]))


def _faces(columns: int, rows: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Unit squares that share nothing: corners (faces * 4, 3), and the faces' numbers of them."""
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    base = np.stack([x.ravel(), y.ravel(), np.zeros(columns * rows)], axis=1)
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    vertices = (base[:, None, :] + corner[None]).reshape(-1, 3)
    return vertices, np.arange(len(vertices)).reshape(-1, 4)


def render(cases: list[dict[str, Any]], columns: int) -> FloatArray:
    """The values, (cases, columns, 3); NaN for cases that this Blender does not know."""
    import bpy

    rows = len(cases)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    scene = bpy.context.scene
    vertices, faces = _faces(columns, rows)
    mesh = bpy.data.meshes.new("pixels")
    mesh.from_pydata(vertices.tolist(), [], faces.tolist())
    attribute = mesh.attributes.new(COORDINATE, "FLOAT_VECTOR", "FACE")
    points = np.concatenate([coordinates(columns, case) for case in range(rows)])
    attribute.data.foreach_set("vector", points.ravel())
    absent: list[int] = []
    for number, case in enumerate(cases):
        material = bpy.data.materials.new(f"case {number}")
        material.use_nodes = True
        mesh.materials.append(material)
        kinds = {spec["kind"] for spec in case["nodes"]}
        if bpy.app.version < (5, 0, 0) and "ShaderNodeTexVoronoi" in kinds:
            absent.append(number)  # it scattered the points of its cells by another hash
            continue
        try:
            _build(material, case)
        except TypeError:  # an enum item that this Blender does not have
            absent.append(number)
    mesh.polygons.foreach_set("material_index", np.repeat(np.arange(rows), columns))
    scene.collection.objects.link(bpy.data.objects.new("pixels", mesh))

    camera = bpy.data.cameras.new("camera")
    camera.type = "ORTHO"
    camera.ortho_scale = max(columns, rows)
    holder = bpy.data.objects.new("camera", camera)
    holder.location = (columns / 2, rows / 2, 10)
    scene.collection.objects.link(holder)
    scene.camera = holder
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = columns, rows
    scene.render.resolution_percentage = 100
    scene.cycles.samples = 1
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.filter_width = 0.01
    scene.cycles.sample_clamp_indirect = 0.0
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "values.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(columns * rows * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        pixels = pixels.reshape(rows, columns, image.channels)
    values = decoded(pixels[..., :3])
    values[absent] = np.nan
    return values


def main() -> None:
    cases_path, result_path, columns = sys.argv[1:4]
    cases = json.loads(Path(cases_path).read_text())
    np.save(result_path, render(cases, int(columns)))
    sys.stdout.flush()
    os._exit(0)  # Blender 4.5 as a module hangs when it exits


if __name__ == "__main__":
    main()
