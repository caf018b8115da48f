"""Hypothesis strategies of scene descriptions: valid ones at the extremes, and broken ones."""

from __future__ import annotations

from typing import Any

import numpy as np
from engine_core.description import (
    Camera,
    Domain,
    Film,
    Graph,
    Image,
    Light,
    Link,
    Material,
    Mesh,
    Node,
    Object,
    SceneDescription,
    World,
)
from hypothesis import strategies as st

FLOAT32_MAX = float(np.finfo(np.float32).max)

#: Numbers that programs stumble over, and any other.
NUMBERS = st.one_of(
    st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, 1e-45, 1e-38, 1e-20, 1e-6, 1e6, 1e18, 1e30,
                     FLOAT32_MAX, -FLOAT32_MAX, 1 + 1e-6, 1 - 1e-6]),
    st.floats(width=32, allow_nan=False, allow_infinity=False),
)  # fmt: skip
USUAL = st.floats(-4, 4, width=32)
POSITIVE = NUMBERS.map(abs)
ANY = st.one_of(NUMBERS, st.sampled_from([float("nan"), float("inf"), -float("inf")]))
COLORS = st.tuples(*[st.one_of(st.floats(0, 1, width=32), POSITIVE)] * 3)
UNITS = st.floats(0, 1, width=32)

CLOSURES = {
    "ShaderNodeBsdfDiffuse": ("Roughness",),
    "ShaderNodeBsdfAnisotropic": ("Roughness", "Anisotropy", "Rotation"),
    "ShaderNodeBsdfGlass": ("Roughness", "IOR"),
    "ShaderNodeBsdfRefraction": ("Roughness", "IOR"),
    "ShaderNodeBsdfTranslucent": (),
    "ShaderNodeBsdfTransparent": (),
    "ShaderNodeBsdfSheen": ("Roughness",),
    "ShaderNodeBsdfMetallic": ("Roughness", "Anisotropy"),
    "ShaderNodeEmission": ("Strength",),
    "ShaderNodeBsdfPrincipled": (
        "Metallic", "Roughness", "IOR", "Alpha", "Coat Weight", "Coat Roughness", "Coat IOR",
        "Sheen Weight", "Sheen Roughness", "Transmission Weight", "Emission Strength",
        "Anisotropic", "Thin Film Thickness", "Thin Film IOR", "Subsurface Weight",
    ),
}  # fmt: skip
VALUES = {
    "ShaderNodeTexNoise": ("Scale", "Detail", "Roughness", "Distortion"),
    "ShaderNodeTexVoronoi": ("Scale", "Randomness"),
    "ShaderNodeTexChecker": ("Scale",),
    "ShaderNodeInvert": ("Fac",),
    "ShaderNodeMath": ("Value", "Value_001", "Value_002"),
    "ShaderNodeFresnel": ("IOR",),
    "ShaderNodeLayerWeight": ("Blend",),
}
OPERATIONS = st.sampled_from(
    ["ADD", "DIVIDE", "POWER", "LOGARITHM", "SQRT", "MODULO", "TANGENT", "WRAP", "SNAP", "EXPONENT"]
)


@st.composite
def arrays(draw: Any, rows: int, columns: int, values: Any = USUAL) -> np.ndarray:
    flat = draw(st.lists(values, min_size=rows * columns, max_size=rows * columns))
    return np.array(flat, np.float32).reshape(rows, columns)


@st.composite
def transforms(draw: Any) -> np.ndarray:
    kind = draw(st.sampled_from(["identity", "moved", "scaled", "any"]))
    rows = np.eye(3, 4, dtype=np.float32)
    if kind == "any":
        return draw(arrays(3, 4, NUMBERS)).copy()
    if kind != "identity":
        rows[:, 3] = draw(st.tuples(*[st.one_of(USUAL, NUMBERS)] * 3))
    if kind == "scaled":
        rows[:, :3] *= np.array(draw(st.tuples(*[st.one_of(USUAL, NUMBERS)] * 3)), np.float32)
    return np.clip(np.nan_to_num(rows), -FLOAT32_MAX, FLOAT32_MAX).astype(np.float32)


@st.composite
def meshes(draw: Any) -> Mesh:
    vertices = draw(st.integers(3, 9))
    positions = draw(arrays(vertices, 3, draw(st.sampled_from([USUAL, NUMBERS]))))
    faces = draw(
        st.lists(st.lists(st.integers(0, vertices - 1), min_size=3, max_size=6), max_size=6)
    )
    corners = np.array([v for face in faces for v in face], np.int32)
    offsets = np.cumsum([0, *(len(face) for face in faces)]).astype(np.int32)
    mesh = Mesh("mesh", positions, corners, offsets)
    domain = draw(st.sampled_from(list(Domain)))
    count = {Domain.FACE: 0, Domain.POINT: vertices, Domain.CORNER: len(corners)}[domain]
    if domain != Domain.FACE:
        mesh.normal_domain = domain
        mesh.normals = draw(arrays(count, 3))
    return mesh


@st.composite
def graphs(draw: Any, images: int) -> Graph:
    """A closure whose inputs are numbers or a short chain of other nodes."""
    nodes: list[Node] = []
    for _ in range(draw(st.integers(0, 3))):
        kind = draw(st.sampled_from(sorted(VALUES)))
        inputs: dict[str, Any] = {name: draw(NUMBERS) for name in VALUES[kind]}
        if nodes and inputs:
            inputs[draw(st.sampled_from(sorted(inputs)))] = Link(
                len(nodes) - 1, output_of(nodes[-1])
            )
        params = {"operation": draw(OPERATIONS)} if kind == "ShaderNodeMath" else {}
        nodes.append(Node(kind, "", inputs, params))
    kind = draw(st.sampled_from(sorted(CLOSURES)))
    closure: dict[str, Any] = {name: draw(st.one_of(UNITS, NUMBERS)) for name in CLOSURES[kind]}
    color = "Base Color" if kind == "ShaderNodeBsdfPrincipled" else "Color"
    closure[color] = Link(len(nodes) - 1, output_of(nodes[-1])) if nodes else (*draw(COLORS), 1.0)
    output = "Emission" if kind == "ShaderNodeEmission" else "BSDF"
    nodes.append(Node(kind, "", closure))
    return Graph(nodes, Link(len(nodes) - 1, output))


def output_of(node: Node) -> str:
    return {"ShaderNodeMath": "Value", "ShaderNodeInvert": "Color", "ShaderNodeTexVoronoi": "Color",
            "ShaderNodeTexChecker": "Color", "ShaderNodeLayerWeight": "Facing"}.get(
        node.kind, "Fac")  # fmt: skip


@st.composite
def lights(draw: Any) -> Light:
    return Light(
        "light",
        draw(st.sampled_from(["POINT", "SPOT", "SUN", "AREA"])),
        draw(transforms()),
        draw(COLORS),
        normalize=draw(st.booleans()),
        radius=draw(POSITIVE),
        soft_falloff=draw(st.booleans()),
        spot_angle=draw(st.one_of(st.floats(0, 3.25, width=32), POSITIVE)),
        spot_blend=draw(UNITS),
        shape=draw(st.sampled_from(["RECTANGLE", "ELLIPSE"])),
        size_x=draw(POSITIVE),
        size_y=draw(POSITIVE),
        spread=draw(st.one_of(st.floats(0, 3.25, width=32), POSITIVE)),
        sun_angle=draw(st.one_of(st.floats(0, 3.25, width=32), POSITIVE)),
        cast_shadow=draw(st.booleans()),
        use_mis=draw(st.booleans()),
    )


@st.composite
def cameras(draw: Any) -> Camera:
    camera = Camera(draw(st.sampled_from(["PERSPECTIVE", "ORTHOGRAPHIC"])))
    camera.transform = draw(transforms())
    half = draw(st.one_of(st.floats(0.0625, 4, width=32), POSITIVE)) or 1.0
    camera.window = (-half, half, -half, half)
    camera.clip_start, camera.clip_end = draw(st.sampled_from([(0.1, 1e3), (1e-30, 1e30), (0, 1)]))
    camera.aperture_radius = draw(st.one_of(st.just(0.0), POSITIVE))
    camera.focus_distance = draw(POSITIVE) or 1.0
    camera.aperture_ratio = draw(POSITIVE) or 1.0
    camera.blades = draw(st.sampled_from([0, 1, 2, 3, 7, 2**31 - 1]))
    camera.blade_rotation = draw(NUMBERS)
    return camera


@st.composite
def images(draw: Any) -> Image:
    height, width = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    channels = draw(st.sampled_from([1, 3, 4]))
    pixels = draw(arrays(height * width, channels, NUMBERS)).reshape(height, width, channels)
    alpha = draw(st.sampled_from(["STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"]))
    return Image("image", pixels, draw(st.sampled_from(["srgb", "linear"])), alpha)


@st.composite
def scenes(draw: Any) -> SceneDescription:
    """A small valid scene, some of whose numbers are at the ends of what is allowed."""
    scene = SceneDescription()
    scene.images = draw(st.lists(images(), max_size=1))
    count = len(scene.images)
    scene.meshes = draw(st.lists(meshes(), max_size=3))
    scene.materials = [Material("m", draw(graphs(count))) for _ in range(draw(st.integers(0, 2)))]
    scene.material_sets = [[draw(st.integers(-1, len(scene.materials) - 1))] for _ in range(2)]
    scene.objects = [Object("object")]
    number = draw(st.integers(0, 4)) if scene.meshes else 0
    i = scene.instances
    i.mesh = np.array(
        [draw(st.integers(0, len(scene.meshes) - 1)) for _ in range(number)], np.int32
    )
    i.transform = np.array([draw(transforms()) for _ in range(number)], np.float32).reshape(
        -1, 3, 4
    )
    i.visibility = np.array([draw(st.integers(0, 31)) for _ in range(number)], np.uint32)
    i.material_set = np.array([draw(st.integers(0, 1)) for _ in range(number)], np.int32)
    i.random = np.full(number, 0.5, np.float32)
    i.object = np.zeros(number, np.int32)
    scene.lights = draw(st.lists(lights(), max_size=3))
    if draw(st.booleans()):
        inputs = {"Color": (*draw(COLORS), 1.0), "Strength": draw(NUMBERS)}
        scene.world = World(
            Graph([Node("ShaderNodeBackground", "", inputs)], Link(0, "Background"))
        )
    scene.camera = draw(cameras())
    scene.film = Film(4, 3, crop=(0, 0, 4, 3), transparent=draw(st.booleans()))
    scene.film.filter = draw(st.sampled_from(["BOX", "GAUSSIAN", "BLACKMAN_HARRIS"]))
    scene.film.filter_width = draw(st.sampled_from([0.0, 0.01, 1.5, 10.0, 1e30]))
    scene.film.exposure = draw(st.sampled_from([0.0, 1.0, 1e6]))
    return scene
