"""Bad input is refused in a sentence that names it, or the rest is drawn: nothing else happens."""

from __future__ import annotations

import re
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from engine_core.description import Graph, Image, Link, Material, Mesh, Node, SceneDescription
from scenes import (
    Array,
    SceneBuilder,
    background,
    box,
    diffuse,
    emission,
    mesh,
    placed,
    quad,
    render,
    shader,
    sphere,
)

import engine_core
from engine_core import DescriptionError

FLOAT32_MAX = 3.4e38
EXTREMES = [1e-45, 1e-38, 1e-30, 1e-20, 1e10, 1e18, 1e20, 1e30, FLOAT32_MAX]
INTEGRATORS = ["PATH", "WHITTED"]
LAMPS = ["POINT", "SPOT", "SUN", "AREA"]


def plain(size: tuple[int, int] = (8, 8)) -> SceneBuilder:
    """A grey ball under an even sky and a lamp."""
    builder = SceneBuilder(size)
    builder.add(sphere(rings=8), diffuse(0.5))
    builder.light("POINT", transform=placed(1.0, (2, 2, 2)), emission=(100.0,) * 3)
    builder.description.world = background(1.0)
    builder.camera((0, 0, 5), (0, 0, 0))
    return builder


def draw(builder: SceneBuilder | SceneDescription, **settings: Any) -> Array:
    """The picture: finite, and made of samples that were all finite (`render` asserts that)."""
    picture = render(builder, ("Combined",), **{"samples": 4, "max_bounces": 20, **settings})
    assert np.isfinite(picture["Combined"]).all()
    return picture["Combined"]


def refused(builder: SceneBuilder | SceneDescription) -> str:
    """The one sentence that refuses the scene."""
    description = builder.description if isinstance(builder, SceneBuilder) else builder
    with pytest.raises(DescriptionError) as caught:
        engine_core.compile(description, threads=1)
    assert "\n" not in str(caught.value)
    return str(caught.value)


# What cannot be drawn is refused.


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_mesh_with_coordinates_that_are_no_numbers_is_named(value: float) -> None:
    builder = plain()
    builder.description.meshes[0].positions[7, 1] = value
    assert refused(builder) == 'mesh "sphere": positions is not finite at element 7'


@pytest.mark.parametrize("index", [-1, 114, 2**31 - 1, -(2**31)])
def test_a_corner_out_of_range_is_named(index: int) -> None:
    builder = plain()
    builder.description.meshes[0].corner_vertices[3] = index
    assert refused(builder).startswith(f'mesh "sphere": corner_vertices is {index} at element 3')


@pytest.mark.parametrize(
    "offsets",
    [[0, 4, 2, 8], [0, -4, 8], [0, 8, 8], [0, 9], [1, 8], [], [0, 2**31 - 1, -2, 8]],
)
def test_faces_out_of_order_are_refused(offsets: list[int]) -> None:
    """The differences of the last case, as 32-bit numbers, go round and are all large enough."""
    shape = Mesh("faces", np.zeros((8, 3), np.float32), np.arange(8, dtype=np.int32) % 8,
                 np.array(offsets, np.int32))  # fmt: skip
    builder = plain()
    builder.add(shape)
    assert refused(builder).startswith('mesh "faces": face')


@pytest.mark.parametrize("field", ["mesh", "material_set", "object"])
def test_an_instance_of_nothing_is_named(field: str) -> None:
    builder = plain()
    getattr(builder.description.instances, field)[0] = 5
    assert f"instances: {field} is 5 at element 0" in refused(builder)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize(
    "field", ["clip_start", "clip_end", "aperture_radius", "focus_distance", "blade_rotation",
              "aperture_ratio"],
)  # fmt: skip
def test_a_camera_s_numbers_must_be_finite(field: str, value: float) -> None:
    builder = plain()
    setattr(builder.description.camera, field, value)
    assert field in refused(builder)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize(
    "field", ["radius", "spot_angle", "spot_blend", "size_x", "size_y", "spread", "sun_angle"]
)
def test_a_lamp_s_numbers_must_be_finite(field: str, value: float) -> None:
    builder = plain()
    setattr(builder.description.lights[0], field, value)
    assert refused(builder).startswith(f'light "light 0": {field} must be')


@pytest.mark.parametrize(
    ("field", "value"),
    [("width", 0), ("width", -5), ("height", 1 << 20), ("width", 8.5), ("width", np.nan),
     ("crop", (0, 0, 8)), ("crop", (0, 0, 9, 8)), ("crop", (0.0, 0.0, 8.0, 8.0)),
     ("crop", (0, 0, np.nan, 8)), ("filter_width", np.nan), ("exposure", np.inf),
     ("pass_alpha_threshold", np.nan)],
)  # fmt: skip
def test_a_film_s_numbers_must_make_sense(field: str, value: Any) -> None:
    builder = plain()
    setattr(builder.description.film, field, value)
    assert re.match(f"the film: {field} ", refused(builder))


def test_numbers_beyond_an_int_are_refused() -> None:
    builder = plain()
    assert builder.description.camera is not None
    builder.description.camera.blades = 2**40
    assert "the camera: blades" in refused(builder)


def test_a_scene_without_a_camera_is_told() -> None:
    builder = plain()
    builder.description.camera = None
    with pytest.raises(ValueError, match="no camera"):
        engine_core.compile(builder.description, threads=1)


def test_cyclic_links_are_named() -> None:
    nodes = [
        Node("ShaderNodeInvert", "a", {"Color": Link(1, "Color")}),
        Node("ShaderNodeInvert", "b", {"Color": Link(0, "Color")}),
        Node("ShaderNodeBsdfDiffuse", "matte", {"Color": Link(0, "Color")}),
    ]
    builder = plain()
    builder.material(Graph(nodes, Link(2, "BSDF")), name="Loop")
    assert refused(builder) == 'material "Loop": links form a cycle at node "a"'


def test_an_error_of_the_caller_s_callback_comes_back() -> None:
    def complain() -> bool:
        raise KeyError("from the callback")

    with pytest.raises(KeyError, match="from the callback"):
        engine_core.compile(plain().description, threads=2, cancelled=complain)
    with pytest.raises(RuntimeError, match="cancelled"):
        engine_core.compile(plain().description, threads=2, cancelled=lambda: True)


def test_a_film_larger_than_memory_is_an_error_not_a_crash() -> None:
    """In a process of its own, whose memory is limited."""
    code = """
import resource, sys
import engine_core
from engine_core.description import Camera, Film, SceneDescription
film = Film(65536, 65536, crop=(0, 0, 65536, 65536))
scene = engine_core.compile(SceneDescription(camera=Camera(), film=film), threads=1)
resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
try:
    engine_core.Session(scene, {"threads": 1}, ["Combined"])
except MemoryError:
    print("out of memory")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "out of memory\n"), done.stderr


# What can be left out is left out.


def matrix(rows: object) -> Array:
    return np.concatenate([np.array(rows, np.float64), np.zeros((3, 1))], axis=1)


MATRICES = {
    "zero": matrix(np.zeros((3, 3))),
    "flat": matrix(np.diag([1, 1, 0])),
    "flat on edge": matrix(np.diag([1, 0, 1])),
    "a line": matrix(np.diag([1, 0, 0])),
    "of rank one": matrix(np.ones((3, 3))),
    "of rank two": matrix([[1, 2, 3], [2, 4, 6], [0, 1, 0]]),
    "nearly flat": matrix(np.diag([1, 1, 1e-38])),
    "mirrored": matrix(np.diag([-1, 1, 1])),
    "tiny": matrix(np.diag([1e-30] * 3)),
    "denormal": matrix(np.diag([1e-40] * 3)),
    "huge": matrix(np.diag([1e30] * 3)),
    "largest": matrix(np.diag([3e38] * 3)),
}


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("count", [1, 3], ids=["one", "instances"])
@pytest.mark.parametrize("graph", [diffuse(0.8), emission(1.0)], ids=["matter", "light"])
@pytest.mark.parametrize("name", MATRICES)
def test_objects_under_any_matrix(name: str, graph: Graph, count: int, integrator: str) -> None:
    builder = plain()
    shape, material = builder.mesh(sphere(rings=6)), builder.material(graph)
    for i in range(count):
        rows = MATRICES[name].copy()
        rows[0, 3] = i - 1
        builder.instance(shape, material, transform=rows.astype(np.float32))
    draw(builder, integrator=integrator)


@pytest.mark.parametrize("count", [1, 2], ids=["one", "instances"])
def test_a_flattened_object_is_still_drawn(count: int) -> None:
    builder = SceneBuilder((8, 8))
    shape, light = builder.mesh(sphere(rings=16)), builder.material(emission(1.0))
    for i in range(count):
        rows = placed((1.0, 1.0, 0.0), (0, 0, -9.0 * i))
        builder.instance(shape, light, transform=rows)
    picture = draw(builder)
    assert np.allclose(picture[3:5, 3:5, :3], 1.0)
    assert not picture[0, 0, :3].any()


@pytest.mark.parametrize("kind", LAMPS)
@pytest.mark.parametrize("name", MATRICES)
def test_lamps_under_any_matrix(name: str, kind: str) -> None:
    builder = plain()
    rows = MATRICES[name].astype(np.float32)
    builder.light(kind, transform=rows, radius=0.5, sun_angle=0.2)
    draw(builder)


@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
@pytest.mark.parametrize("name", MATRICES)
def test_cameras_under_any_matrix(name: str, kind: str) -> None:
    builder = plain()
    builder.camera((0, 0, 5), (0, 0, 0), kind=kind, transform=MATRICES[name].astype(np.float32))
    draw(builder)


@pytest.mark.parametrize("value", EXTREMES)
@pytest.mark.parametrize("kind", LAMPS)
def test_lamps_of_extreme_power_size_and_place(kind: str, value: float) -> None:
    builder = plain()
    above = placed(1.0, (0, 0, 3))
    names = ("radius", "sun_angle", "size_x", "size_y", "spread", "spot_angle")
    builder.light(kind, emission=(value,) * 3, transform=above, radius=0.1, sun_angle=0.1)
    draw(builder)
    builder.description.lights.pop()
    builder.light(kind, transform=above, **dict.fromkeys(names, value))
    draw(builder)
    builder.description.lights.pop()
    builder.light(kind, transform=placed(1.0, (value, 0, 3)), radius=0.1)
    draw(builder)


@pytest.mark.parametrize("kind", LAMPS)
def test_lamps_without_size(kind: str) -> None:
    builder = plain()
    names = ("radius", "sun_angle", "size_x", "size_y", "spread", "spot_angle")
    builder.light(kind, transform=placed(1.0, (0, 0, 3)), **dict.fromkeys(names, 0.0))
    draw(builder)
    for integrator in INTEGRATORS:
        draw(builder, integrator=integrator)


@pytest.mark.parametrize("value", EXTREMES)
def test_objects_of_extreme_size_and_place(value: float) -> None:
    for graph in (diffuse(0.5), emission(1.0)):
        builder = plain()
        builder.add(sphere(value, rings=6), graph)
        builder.add(quad((value, value, value), (1, 0, 0), (0, 1, 0)), graph)
        draw(builder)


@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
@pytest.mark.parametrize("value", EXTREMES)
def test_cameras_of_extreme_optics(value: float, kind: str) -> None:
    fields = ("aperture_radius", "focus_distance", "aperture_ratio", "blade_rotation")
    for field in fields:
        builder = plain()
        builder.camera((0, 0, 5), (0, 0, 0), kind=kind, **{"aperture_radius": 0.1, field: value})
        draw(builder)
    builder.camera((0, 0, 5), (0, 0, 0), kind=kind, window=(-value, value, -value, value))
    draw(builder)
    builder.camera((0, 0, value), (0, 0, 0), kind=kind, clip_start=min(value, 1e38))
    builder.description.camera.clip_end = FLOAT32_MAX
    draw(builder)


@pytest.mark.parametrize("value", [-1.0, 0.0, *EXTREMES])
def test_materials_with_extreme_numbers(value: float) -> None:
    color = (value, value, value, 1.0)
    graphs = [
        diffuse(value),
        emission(value),
        shader("ShaderNodeBsdfPrincipled", Base_Color=color, Roughness=value, Metallic=value,
               IOR=value, Coat_Weight=value, Sheen_Weight=value, Transmission_Weight=0.5),
        shader("ShaderNodeBsdfGlass", Color=color, Roughness=value, IOR=value),
        shader("ShaderNodeBsdfAnisotropic", Color=color, Roughness=value, Anisotropy=value),
    ]  # fmt: skip
    for graph in graphs:
        builder = plain()
        builder.add(box((-6, -6, -6), (6, 6, 6), inward=True), graph)
        scene = engine_core.compile(builder.description, threads=1)
        session = engine_core.Session(scene, {"samples": 4, "max_bounces": 20}, ["Combined"])
        session.start()
        while not session.wait(10.0):
            pass
        # Surfaces that return more than they get may go beyond any number: such samples are
        # dropped, and counted.
        assert np.isfinite(session.read("Combined", 0, 0, 8, 8)).all()
        assert value > 1.0 or session.poll().non_finite == 0


@pytest.mark.parametrize("pixels", [None, np.zeros((1, 1, 1), np.uint8),
                                    np.full((2, 3, 4), FLOAT32_MAX, np.float32),
                                    np.full((2, 3, 3), -FLOAT32_MAX, np.float32)])  # fmt: skip
def test_missing_and_odd_images(pixels: Any) -> None:
    builder = plain()
    builder.description.images.append(Image("picture", pixels))
    nodes = [
        Node("ShaderNodeTexImage", "texture", {}, {"image": 0}),
        Node("ShaderNodeBsdfDiffuse", "matte", {"Color": Link(0, "Color")}),
    ]
    builder.add(sphere(1.5, rings=8), Graph(nodes, Link(1, "BSDF")))
    draw(builder)


def test_a_missing_image_is_magenta() -> None:
    builder = SceneBuilder((4, 4))
    builder.description.images.append(Image("lost", None))
    nodes = [
        Node("ShaderNodeTexImage", "texture", {}, {"image": 0}),
        Node("ShaderNodeEmission", "light", {"Color": Link(0, "Color"), "Strength": 1.0}),
    ]
    builder.add(quad((-9, -9, 0), (18, 0, 0), (0, 18, 0)), Graph(nodes, Link(1, "Emission")))
    assert np.allclose(draw(builder)[..., :3], (1, 0, 1))


@pytest.mark.parametrize("shape", [(0, 0, 4), (4, 0, 3), (2, 2, 2), (4, 4)])
def test_empty_and_truncated_images_are_refused(shape: tuple[int, ...]) -> None:
    builder = plain()
    builder.description.images.append(Image("odd", np.zeros(shape, np.uint8)))
    assert refused(builder).startswith('image "odd": pixels ')


def test_unknown_nodes_are_told_and_replaced() -> None:
    builder = plain()
    unknown = Node("ShaderNodeFromTheFuture", "new")
    graphs = [
        Graph([unknown], Link(0, "BSDF")),
        Graph([unknown, Node("ShaderNodeBsdfDiffuse", "", {"Color": Link(0, "Color")})],
              Link(1, "BSDF")),
        Graph([Node("ShaderNodeBsdfDiffuse", "", {"Flavour": 3.0})], Link(0, "Taste")),
        Graph([Node("ShaderNodeMath", "", {}, {"operation": "PRAY"})], Link(0, "Value")),
    ]  # fmt: skip
    for graph in graphs:
        builder.add(sphere(rings=4), graph)
    builder.description.world.graph = graphs[0]
    scene = engine_core.compile(builder.description, threads=1)
    assert any("material 1" in warning and "new" in warning for warning in scene.warnings)
    draw(builder)


@pytest.mark.parametrize("kind", ["ShaderNodeMixRGB", "ShaderNodeInvert", "ShaderNodeMath"])
def test_a_material_of_ten_thousand_nodes(kind: str) -> None:
    count = 10_000
    first = {"ShaderNodeMixRGB": "Color1", "ShaderNodeInvert": "Color", "ShaderNodeMath": "Value"}
    output = "Value" if kind == "ShaderNodeMath" else "Color"
    nodes = [Node("ShaderNodeTexCoord", "coordinates")]
    nodes += [
        Node(kind, f"{i}", {first[kind]: Link(i, output if i else "Object")}) for i in range(count)
    ]
    nodes.append(Node("ShaderNodeBsdfDiffuse", "matte", {"Color": Link(count, output)}))
    builder = plain((4, 4))
    builder.add(sphere(1.5, rings=4), Graph(nodes, Link(count + 1, "BSDF")))
    draw(builder, samples=1)


def test_a_graph_whose_paths_double_at_every_node() -> None:
    """Two to the power of sixty ways through it: nodes must be met once each."""
    nodes = [Node("ShaderNodeTexCoord", "coordinates")]
    for i in range(60):
        link = Link(i, "Color" if i else "Object")
        nodes.append(Node("ShaderNodeMixRGB", f"{i}", {"Color1": link, "Color2": link}))
    nodes.append(Node("ShaderNodeBsdfDiffuse", "matte", {"Color": Link(60, "Color")}))
    builder = plain((4, 4))
    builder.add(sphere(1.5, rings=4), Graph(nodes, Link(61, "BSDF")))
    draw(builder)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_scenes_of_nothing(integrator: str) -> None:
    empty = SceneBuilder((4, 4))
    assert not draw(empty, integrator=integrator)[..., :3].any()
    dark = SceneBuilder((4, 4))
    dark.add(sphere(rings=4), diffuse(0.5))
    assert not draw(dark, integrator=integrator)[..., :3].any()
    no_faces = plain((4, 4))
    no_faces.add(mesh("points", np.zeros((3, 3)), []), diffuse(0.5))
    no_faces.add(mesh("nothing", np.zeros((0, 3)), []), emission(1.0))
    assert draw(no_faces, integrator=integrator)[..., :3].any()
    only_those = SceneBuilder((4, 4))
    only_those.add(mesh("nothing", np.zeros((0, 3)), []), emission(1.0))
    assert not draw(only_those, integrator=integrator)[..., :3].any()


def test_degenerate_triangles_and_normals() -> None:
    points = [(0, 0, 0), (0, 0, 0), (0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0), (0, 1, 1e-30)]
    for graph in (diffuse(0.5), emission(5.0)):
        builder = plain()
        builder.add(mesh("slivers", points, [(0, 1, 2), (3, 4, 5), (0, 3, 5), (0, 3, 6)]), graph)
        zero_normals = sphere(1.2, rings=8)
        assert zero_normals.normals is not None
        zero_normals.normals[:] = 0.0
        builder.add(zero_normals, graph)
        draw(builder)


def test_normals_that_point_inside() -> None:
    for kind in ("ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlass", "ShaderNodeBsdfPrincipled"):
        builder = plain()
        wrong = sphere(1.5, rings=8)
        assert wrong.normals is not None
        wrong.normals *= -1
        builder.add(wrong, shader(kind, Roughness=0.3))
        draw(builder)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("kind", ["ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlass"])
def test_a_camera_within_a_closed_object(kind: str, integrator: str) -> None:
    builder = plain()
    builder.add(sphere(5.5, rings=8), shader(kind, Roughness=0.0))
    draw(builder, integrator=integrator, whitted_depth=6)


@pytest.mark.parametrize("size", [(1, 1), (4096, 2), (2, 4096)])
def test_films_of_extreme_shape(size: tuple[int, int]) -> None:
    picture = draw(plain(size), samples=1)
    assert picture.shape == (size[1], size[0], 4)


def test_a_hundred_thousand_instances(rng: np.random.Generator) -> None:
    count = 100_000
    builder = plain()
    description = builder.description
    shape = builder.mesh(box((-0.1,) * 3, (0.1,) * 3))
    builder.instance(shape, builder.material(diffuse(0.5)))
    i = description.instances
    many = np.tile(np.eye(3, 4, dtype=np.float32), (count, 1, 1))
    many[:, :, 3] = rng.uniform(-50, 50, (count, 3))
    i.transform = np.concatenate([i.transform, many])
    for name in ("mesh", "visibility", "material_set", "random", "object"):
        column = getattr(i, name)
        setattr(i, name, np.concatenate([column, np.repeat(column[-1:], count)]))
    draw(builder)
    assert engine_core.compile(description, threads=2).requirements["instances"] == count + 2


def test_slots_without_materials_are_grey() -> None:
    builder = SceneBuilder((4, 4))
    shape = quad((-9, -9, 0), (18, 0, 0), (0, 18, 0))
    shape.face_materials = np.array([65535], np.int32)
    builder.instance(builder.mesh(shape))
    builder.description.materials.append(Material("unused"))
    builder.description.world = background(1.0)
    assert np.allclose(draw(builder, samples=64)[..., :3].mean(), 0.8, atol=0.05)
