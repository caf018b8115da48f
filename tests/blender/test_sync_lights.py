"""Lamps: Blender's numbers to the description's."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest
from engine_core.description import Link, Visibility


def _lamp(make: Any, kind: str) -> Any:
    item = make.object("Lamp", bpy.data.lights.new("Lamp", kind))
    item.location = (1, 2, 3)
    item.data.energy = 40.0
    item.data.color = (1.0, 0.5, 0.25)
    return item


def test_point(make: Any, export: Any) -> None:
    lamp = _lamp(make, "POINT").data
    lamp.shadow_soft_size, lamp.use_soft_falloff = 0.3, False
    light = export()[0].lights[0]
    assert (light.kind, light.soft_falloff) == ("POINT", False)
    assert light.emission == pytest.approx((40.0, 20.0, 10.0))
    assert light.radius == pytest.approx(0.3)
    np.testing.assert_allclose(light.transform, np.c_[np.eye(3), (1, 2, 3)])


def test_exposure_counts_in_stops(make: Any, export: Any) -> None:
    _lamp(make, "POINT").data.exposure = 2.0
    assert export()[0].lights[0].emission == pytest.approx((160.0, 80.0, 40.0))


def test_temperature_tints(make: Any, export: Any) -> None:
    lamp = _lamp(make, "POINT").data
    lamp.color = (1, 1, 1)
    lamp.use_temperature, lamp.temperature = True, 3000.0
    emission = export()[0].lights[0].emission
    assert emission == pytest.approx(tuple(40.0 * x for x in lamp.temperature_color[:3]))
    assert emission[0] > 2.0 * emission[2]


def test_spot(make: Any, export: Any) -> None:
    lamp = _lamp(make, "SPOT").data
    lamp.spot_size, lamp.spot_blend, lamp.shadow_soft_size = 1.1, 0.4, 0.2
    light = export()[0].lights[0]
    assert light.kind == "SPOT"
    assert (light.spot_angle, light.spot_blend) == pytest.approx((1.1, 0.4))


def test_sun(make: Any, export: Any) -> None:
    lamp = _lamp(make, "SUN").data
    lamp.angle = 0.02
    light = export()[0].lights[0]
    assert light.kind == "SUN"
    assert light.sun_angle == pytest.approx(0.02)
    assert light.emission == pytest.approx((40.0, 20.0, 10.0))


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ("SQUARE", ("RECTANGLE", 0.5, 0.5)),
        ("RECTANGLE", ("RECTANGLE", 0.5, 0.8)),
        ("DISK", ("ELLIPSE", 0.5, 0.5)),
        ("ELLIPSE", ("ELLIPSE", 0.5, 0.8)),
    ],
)
def test_area(make: Any, export: Any, shape: str, expected: Any) -> None:
    lamp = _lamp(make, "AREA").data
    lamp.shape, lamp.size, lamp.size_y, lamp.spread = shape, 0.5, 0.8, 1.0
    lamp.normalize = False
    light = export()[0].lights[0]
    assert light.shape == expected[0]
    assert (light.size_x, light.size_y) == pytest.approx(expected[1:])
    assert (light.spread, light.normalize) == (1.0, False)


def test_scale_stays_in_the_transform(make: Any, export: Any) -> None:
    item = _lamp(make, "AREA")
    item.scale = (2.0, 3.0, 1.0)
    np.testing.assert_allclose(export()[0].lights[0].transform[:, :3], np.diag((2.0, 3.0, 1.0)))


def test_empty_and_flat_lamps_are_ordinary(make: Any, export: Any) -> None:
    item = _lamp(make, "AREA")
    item.data.size = 0.0
    item.scale = (0.0, 0.0, 0.0)
    assert export()[0].lights[0].size_x == 0.0


def test_lamps_are_hidden_from_the_camera_unless_asked(make: Any, export: Any) -> None:
    item = _lamp(make, "POINT")
    assert export()[0].lights[0].visibility == Visibility.ALL & ~Visibility.CAMERA
    item.visible_camera, item.visible_glossy = True, False
    expected = Visibility.ALL & ~Visibility.GLOSSY
    bpy.context.view_layer.update()
    assert export()[0].lights[0].visibility == expected


def test_shadowless(make: Any, export: Any) -> None:
    _lamp(make, "POINT").data.use_shadow = False
    assert export()[0].lights[0].cast_shadow is False


def test_nodes(make: Any, export: Any) -> None:
    lamp = _lamp(make, "POINT").data
    if bpy.app.version < (5, 0, 0):
        lamp.use_nodes = True
    emission = next(n for n in lamp.node_tree.nodes if n.bl_idname == "ShaderNodeEmission")
    emission.inputs["Strength"].default_value = 3.0
    graph = export()[0].lights[0].graph
    assert graph.surface == Link(0, "Emission")
    assert graph.nodes[0].inputs["Strength"] == 3.0


def test_without_nodes_the_graph_is_empty(make: Any, export: Any) -> None:
    if bpy.app.version >= (5, 0, 0):
        pytest.skip("lights always have nodes from 5.0 on")
    _lamp(make, "POINT")
    assert export()[0].lights[0].graph.surface is None


def test_instanced_lamps(make: Any, export: Any) -> None:
    collection = bpy.data.collections.new("Fixture")
    lamp = make.object("Bulb", bpy.data.lights.new("Bulb", "POINT"), collection)
    lamp.location = (0, 0, 1)
    for number in range(3):
        holder = make.object(f"Holder {number}", None)
        holder.location = (number, 0, 0)
        holder.instance_type, holder.instance_collection = "COLLECTION", collection
    places = sorted(tuple(light.transform[:, 3]) for light in export()[0].lights)
    assert places == [(0, 0, 1), (1, 0, 1), (2, 0, 1)]


def test_world_without_nodes(empty_scene: Any, export: Any) -> None:
    if bpy.app.version >= (5, 0, 0):
        pytest.skip("worlds always have nodes from 5.0 on")
    empty_scene.world = bpy.data.worlds.new("Plain")
    empty_scene.world.use_nodes = False
    empty_scene.world.color = (0.1, 0.2, 0.3)
    graph = export()[0].world.graph
    assert graph.nodes[0].inputs["Color"] == pytest.approx((0.1, 0.2, 0.3, 1.0))


def test_world_with_nodes(empty_scene: Any, export: Any) -> None:
    empty_scene.world = bpy.data.worlds.new("Sky")
    if bpy.app.version < (5, 0, 0):
        empty_scene.world.use_nodes = True
    background = empty_scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (1, 2, 3, 1)
    background.inputs["Strength"].default_value = 0.5
    graph = export()[0].world.graph
    assert graph.nodes[graph.surface.node].kind == "ShaderNodeBackground"
    assert graph.nodes[0].inputs == {"Color": (1, 2, 3, 1), "Strength": 0.5}


def test_no_world_is_black(empty_scene: Any, export: Any) -> None:
    assert export()[0].world.graph.surface is None


def test_layer_without_sky(empty_scene: Any, export: Any) -> None:
    empty_scene.world = bpy.data.worlds.new("Sky")
    bpy.context.view_layer.use_sky = False
    assert export()[0].world.graph.surface is None
