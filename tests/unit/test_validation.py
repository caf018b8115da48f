"""Every rule of a scene description has a case that breaks it, and one sentence that says so."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from engine_core.description import (
    Attribute,
    Camera,
    Domain,
    Graph,
    Image,
    Instances,
    Light,
    Link,
    Material,
    Mesh,
    Node,
    Object,
    SceneDescription,
)
from engine_core.validation import DescriptionError, validate


def example() -> SceneDescription:
    """A description that uses every kind of member."""
    mesh = Mesh(
        name="Quad",
        positions=np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], np.float32),
        corner_vertices=np.arange(4, dtype=np.int32),
        face_offsets=np.array([0, 4], np.int32),
        face_materials=np.zeros(1, np.int32),
        normal_domain=Domain.POINT,
        normals=np.tile(np.array([0, 0, 1], np.float32), (4, 1)),
        attributes=[Attribute("Map", Domain.CORNER, np.zeros((4, 2), np.float32))],
        active_uv="Map",
    )
    graph = Graph(
        [
            Node("ShaderNodeTexImage", "Picture", {}, {"image": 0, "extension": "REPEAT"}),
            Node("ShaderNodeValToRGB", "Ramp", {"Fac": Link(0, "Color")},
                 {"ramp": np.array([0, 0, 0, 0, 1], np.float32)}),
            Node("ShaderNodeBsdfDiffuse", "Diffuse", {"Color": Link(1, "Color"), "Roughness": 0.5}),
        ],
        Link(2, "BSDF"),
    )  # fmt: skip
    return SceneDescription(
        meshes=[mesh],
        material_sets=[[0, -1]],
        instances=Instances(
            mesh=np.zeros(1, np.int32),
            transform=np.eye(3, 4, dtype=np.float32)[None],
            visibility=np.full(1, 31, np.uint32),
            material_set=np.zeros(1, np.int32),
            random=np.full(1, 0.5, np.float32),
            object=np.zeros(1, np.int32),
        ),
        objects=[Object("Quad")],
        materials=[Material("Material", graph)],
        images=[Image("Picture", np.zeros((2, 2, 3), np.uint8)), Image("Missing", None)],
        lights=[Light("Lamp", "AREA")],
        camera=Camera(),
    )


def test_the_example_and_the_empty_scene_are_valid() -> None:
    validate(example())
    validate(SceneDescription())


def _set(path: str, value: Any) -> Callable[[SceneDescription], None]:
    """Sets a member: `meshes.0.positions` and the like."""

    def change(description: SceneDescription) -> None:
        *parents, last = path.split(".")
        target: Any = description
        for part in parents:
            target = target[int(part)] if part.isdigit() else getattr(target, part)
        setattr(target, last, value)

    return change


def _poke(path: str, index: Any, value: Any) -> Callable[[SceneDescription], None]:
    """Sets an element of an array or a table."""

    def change(description: SceneDescription) -> None:
        target: Any = description
        for part in path.split("."):
            target = target[int(part)] if part.isdigit() else getattr(target, part)
        target[index] = value

    return change


NAN = float("nan")
MESH, GRAPH = "meshes.0", "materials.0.graph"
BROKEN: list[tuple[Callable[[SceneDescription], None], str]] = [
    (_poke(f"{MESH}.positions", (2, 1), NAN), 'mesh "Quad": positions is not finite at element 2'),
    (_set(f"{MESH}.positions", np.zeros((4, 3))), "must be an array of float32, not float64"),
    (_set(f"{MESH}.positions", np.zeros((4, 2), np.float32)), r"shape \(n, 3\), not \(4, 2\)"),
    (_set(f"{MESH}.positions", np.zeros((3, 4), np.float32).T), r"shape|contiguous"),
    (_set(f"{MESH}.positions", np.zeros((4, 6), np.float32)[:, ::2]), "must be C-contiguous"),
    (
        _set(f"{MESH}.positions", np.zeros(49, np.uint8)[1:].view(np.float32).reshape(4, 3)),
        "must be aligned to the size of its numbers",
    ),
    (_set(f"{MESH}.positions", None), "must be an array of float32, not NoneType"),
    (
        _poke(f"{MESH}.corner_vertices", 1, 4),
        "corner_vertices is 4 at element 1, outside of 0 to 3",
    ),
    (_poke(f"{MESH}.corner_vertices", 1, -1), "corner_vertices is -1 at element 1"),
    (_poke(f"{MESH}.face_offsets", 1, 5), "must go from 0 to the number of corners, 4"),
    (_set(f"{MESH}.face_offsets", np.array([0, 2, 4], np.int32)), "fewer than three corners"),
    (_poke(f"{MESH}.face_materials", 0, -1), "face_materials is -1"),
    (_set(f"{MESH}.face_materials", np.zeros(2, np.int32)), r"shape \(1\), not \(2,\)"),
    (_set(f"{MESH}.normal_domain", Domain.FACE), "normals must be None"),
    (_poke(f"{MESH}.normals", (0, 0), np.inf), "normals is not finite"),
    (_set(f"{MESH}.attributes.0.data", np.zeros((3, 2), np.float32)), 'attribute "Map"'),
    (_set(f"{MESH}.attributes.0.data", np.zeros((4, 5), np.float32)), "1 to 4 channels"),
    (_poke(f"{MESH}.attributes.0.data", (3, 1), NAN), "is not finite at element 3"),
    (_set(f"{MESH}.texture_space_min", (0.0, NAN, 0.0)), "texture_space_min"),
    (_poke("material_sets.0", 0, 1), "slot 0 names material 1 of 1"),
    (_set("material_sets", [[]]), "material set 0: has no slot"),
    (_poke("instances.mesh", 0, 1), "instances: mesh is 1 at element 0"),
    (_poke("instances.object", 0, -1), "instances: object is -1"),
    (_poke("instances.material_set", 0, 3), "instances: material_set is 3"),
    (_poke("instances.visibility", 0, 32), "instances: visibility is 32"),
    (_poke("instances.transform", (0, 1, 3), NAN), "transform is not finite at element 0"),
    (_poke("instances.random", 0, 1.0), r"random is outside of \[0, 1\)"),
    (_set("instances.random", np.zeros(2, np.float32)), "random must have shape"),
    (_set("images.0.pixels", np.zeros((2, 2, 2), np.uint8)), "1, 3 or 4 channels, not 2"),
    (_set("images.0.pixels", np.zeros((0, 2, 3), np.uint8)), "pixels are empty"),
    (_set("images.0.pixels", np.zeros((2, 2, 3), np.int16)), "array of uint8, not int16"),
    (_set("images.0.pixels", np.full((1, 1, 3), NAN, np.float32)), "not finite"),
    (_set("images.0.encoding", "rec709"), "encoding must be one of srgb, linear"),
    (_set(f"{GRAPH}.surface", Link(3, "BSDF")), "surface is linked to node 3 of 3"),
    (_poke(f"{GRAPH}.nodes.2.inputs", "Color", Link(-1, "Color")), "linked to node -1 of 3"),
    (_poke(f"{GRAPH}.nodes.0.inputs", "Vector", Link(1, "Color")), 'cycle at node "Picture"'),
    (_poke(f"{GRAPH}.nodes.0.params", "image", 2), "names image 2 of 2"),
    (_poke(f"{GRAPH}.nodes.2.inputs", "Roughness", NAN), 'node "Diffuse".*"Roughness"'),
    (_poke(f"{GRAPH}.nodes.2.inputs", "Roughness", 1e39), '"Roughness" must be finite'),
    (_poke(f"{GRAPH}.nodes.2.inputs", "Color", (1.0,) * 5), "1 to 4 numbers"),
    (_poke(f"{GRAPH}.nodes.1.params", "ramp", np.array([NAN], np.float32)), "not finite"),
    (_poke(f"{GRAPH}.nodes.1.params", "ramp", [1.0]), "is a list"),
    (_set("lights.0.kind", "HEMI"), 'light "Lamp": kind must be one of POINT'),
    (_set("lights.0.size_x", -1.0), "size_x must be at least 0, not -1"),
    (_set("lights.0.emission", (1.0, NAN, 1.0)), "emission must be finite"),
    (_set("lights.0.spot_blend", 1.5), r"spot_blend must lie in \[0, 1\]"),
    (_set("lights.0.visibility", 64), "visibility must be bits of 31"),
    (_set("lights.0.transform", np.eye(4, dtype=np.float32)), r"shape \(3, 4\)"),
    (_set("world.visibility", -1), "the world: visibility"),
    (_set("camera.window", (1.0, -1.0, -1.0, 1.0)), "window is empty"),
    (_set("camera.clip_start", 1000.0), "clip_start 1000 is not below clip_end 1000"),
    (_set("camera.aperture_ratio", 0.0), "must be positive"),
    (_set("camera.kind", "FISHEYE"), "kind must be one of"),
    (_set("film.width", 0), "the film: width must lie in 1 to 65536, not 0"),
    (_set("film.crop", (0, 0, 641, 360)), "outside of 640 x 360 pixels"),
    (_set("film.crop", (5, 0, 5, 360)), "is empty"),
    (_set("film.exposure", -1.0), "exposure must be at least 0"),
    (_set("film.filter", "MITCHELL"), "filter must be one of"),
    (_set("film.pass_alpha_threshold", 1.5), r"pass_alpha_threshold must lie in \[0, 1\], not 1.5"),
]


@pytest.mark.parametrize(("change", "pattern"), BROKEN, ids=[text for _, text in BROKEN])
def test_a_broken_rule_is_named(change: Callable[[SceneDescription], None], pattern: str) -> None:
    description = example()
    change(description)
    with pytest.raises(DescriptionError, match=pattern) as caught:
        validate(description)
    assert "\n" not in str(caught.value)


def test_attributes_of_one_name_are_refused() -> None:
    description = example()
    description.meshes[0].attributes *= 2
    with pytest.raises(DescriptionError, match='attribute "Map" occurs twice'):
        validate(description)


def test_long_chains_do_not_exhaust_the_stack() -> None:
    nodes = [Node("ShaderNodeInvert", "first")]
    nodes += [Node("ShaderNodeInvert", f"{i}", {"Color": Link(i, "Color")}) for i in range(20_000)]
    validate(SceneDescription(materials=[Material("Long", Graph(nodes, Link(20_000, "Color")))]))
