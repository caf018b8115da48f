"""The scene description: the one thing that crosses from Blender to the core.

This module is the written specification. Arrays are numpy, C-contiguous, of the dtype given;
lengths are in metres, angles in radians, matrices are the first three rows of object-to-world
matrices. `validate` (in `engine_core.validation`) states and checks every rule; `save` and `load`
(in `engine_core.storage`) keep a description in a file. Nothing here knows Blender.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum, IntFlag

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float32]
IntArray = NDArray[np.int32]
UintArray = NDArray[np.uint32]


class Domain(IntEnum):
    """The elements of a mesh that an attribute lives on."""

    POINT = 0
    FACE = 1
    CORNER = 2


class Visibility(IntFlag):
    """Which rays see an object, a light or the world."""

    CAMERA = 1
    DIFFUSE = 2
    GLOSSY = 4
    TRANSMISSION = 8
    SHADOW = 16
    ALL = 31


@dataclass
class Attribute:
    """Values on the elements of a mesh: `data` is (elements, 1 to 4) float32.

    UV maps are corner attributes of 2 channels under their own name. The tangents of UV map `x`
    (MikkTSpace) are a corner attribute of 4 channels named `tangent:x`, w the bitangent's sign.
    Colours are scene linear.
    """

    name: str
    domain: Domain
    data: FloatArray


@dataclass
class Mesh:
    """Polygons. Triangulation is the core's work."""

    name: str
    positions: FloatArray  # (vertices, 3), object space
    corner_vertices: IntArray  # (corners,)
    face_offsets: IntArray  # (faces + 1,): first corner of each face; last: number of corners
    face_materials: IntArray | None = None  # (faces,) slot; None: slot 0 everywhere
    normal_domain: Domain = Domain.FACE  # FACE: flat shading, and `normals` is None
    normals: FloatArray | None = None  # (elements of normal_domain, 3), object space
    attributes: list[Attribute] = field(default_factory=list)
    texture_space_min: tuple[float, float, float] = (-1.0, -1.0, -1.0)
    texture_space_max: tuple[float, float, float] = (1.0, 1.0, 1.0)
    active_uv: str = ""  # the UV map that nodes which name none use
    active_color: str = ""  # the colour attribute that nodes which name none use


@dataclass
class Instances:
    """All instances, one row each; a mesh used once is an instance too."""

    mesh: IntArray = field(default_factory=lambda: np.zeros(0, np.int32))
    transform: FloatArray = field(default_factory=lambda: np.zeros((0, 3, 4), np.float32))
    visibility: UintArray = field(default_factory=lambda: np.zeros(0, np.uint32))
    material_set: IntArray = field(default_factory=lambda: np.zeros(0, np.int32))
    random: FloatArray = field(default_factory=lambda: np.zeros(0, np.float32))
    object: IntArray = field(default_factory=lambda: np.zeros(0, np.int32))


@dataclass
class Object:
    """What an instance's object tells to shaders and passes."""

    name: str
    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    location: tuple[float, float, float] = (0.0, 0.0, 0.0)
    pass_index: float = 0.0
    shadow_catcher: bool = False
    holdout: bool = False


@dataclass(frozen=True)
class Link:
    """The output socket `output` (Blender's identifier) of node number `node`."""

    node: int
    output: str


InputValue = Link | float | tuple[float, ...]
ParamValue = bool | int | float | str | FloatArray


@dataclass
class Node:
    """A shader node in Blender's vocabulary.

    `kind` is the node's `bl_idname`; `inputs` are keyed by socket identifier; `params` by RNA
    property, enums as their identifiers. `engine_core.probe.node_kind_rows()` lists what the core
    knows. Blender properties that are no plain values have these forms: `image` is an index into
    `SceneDescription.images` (-1: none chosen); a colour ramp is `ramp`, a flat float array of
    rows (position, r, g, b, a), with `interpolation` and `color_mode`; curves are sampled tables.
    """

    kind: str
    name: str = ""
    inputs: dict[str, InputValue] = field(default_factory=dict)
    params: dict[str, ParamValue] = field(default_factory=dict)


@dataclass
class Graph:
    """A flat, acyclic node tree: groups, reroutes and muted nodes are resolved."""

    nodes: list[Node] = field(default_factory=list)
    surface: Link | None = None


@dataclass
class Material:
    name: str
    graph: Graph = field(default_factory=Graph)
    pass_index: float = 0.0


@dataclass
class Image:
    """Pixels (height, width, channels), bottom row first, uint8 or float32; 1, 3 or 4 channels.

    `pixels` None: the image is missing and is drawn magenta. `encoding` is `srgb` or `linear`;
    any other colour space was converted to linear float32 before.
    """

    name: str
    pixels: NDArray[np.uint8] | FloatArray | None
    encoding: str = "srgb"
    alpha: str = "STRAIGHT"  # STRAIGHT, PREMUL, CHANNEL_PACKED, NONE


@dataclass
class Light:
    """A lamp. It shines along the -z axis of its transform."""

    name: str
    kind: str = "POINT"  # POINT, SPOT, SUN, AREA
    transform: FloatArray = field(default_factory=lambda: np.eye(3, 4, dtype=np.float32))
    emission: tuple[float, float, float] = (1.0, 1.0, 1.0)  # colour times watts; sun: W/m^2
    normalize: bool = True  # area: emission is the total power, else per surface area of 1 m^2
    radius: float = 0.0
    soft_falloff: bool = True
    spot_angle: float = 0.785398
    spot_blend: float = 0.15
    shape: str = "RECTANGLE"  # RECTANGLE, ELLIPSE (squares and disks have equal sizes)
    size_x: float = 1.0
    size_y: float = 1.0
    spread: float = 3.14159265
    sun_angle: float = 0.0
    visibility: int = Visibility.ALL & ~Visibility.CAMERA
    cast_shadow: bool = True
    use_mis: bool = True
    graph: Graph = field(default_factory=Graph)  # an Emission shader that multiplies; or empty


@dataclass
class World:
    graph: Graph = field(default_factory=Graph)  # empty: black
    visibility: int = Visibility.ALL


@dataclass
class Camera:
    """It looks along -z with +y up; the transform carries no scale."""

    kind: str = "PERSPECTIVE"  # PERSPECTIVE, ORTHOGRAPHIC
    transform: FloatArray = field(default_factory=lambda: np.eye(3, 4, dtype=np.float32))
    # left, right, bottom, top of the full picture on the plane z = -1 (perspective) or in metres
    # (orthographic); lens shift is part of it.
    window: tuple[float, float, float, float] = (-0.36, 0.36, -0.2025, 0.2025)
    clip_start: float = 0.1
    clip_end: float = 1000.0
    aperture_radius: float = 0.0
    focus_distance: float = 10.0
    blades: int = 0
    blade_rotation: float = 0.0
    aperture_ratio: float = 1.0


@dataclass
class Film:
    width: int = 640
    height: int = 360
    crop: tuple[int, int, int, int] = (0, 0, 640, 360)  # x0, y0, x1, y1, y upward
    filter: str = "BLACKMAN_HARRIS"  # BOX, GAUSSIAN, BLACKMAN_HARRIS
    # Pixels, as Blender names it: the extent of a box, a third of a Gaussian's, half of a
    # Blackman-Harris window's.
    filter_width: float = 1.5
    exposure: float = 1.0
    transparent: bool = False
    # Least opacity [0, 1] of the surfaces whose normal and UV the passes show; less opaque ones
    # leave them to what is behind.
    pass_alpha_threshold: float = 0.5


@dataclass
class SceneDescription:
    meshes: list[Mesh] = field(default_factory=list)
    material_sets: list[list[int]] = field(default_factory=list)  # per slot; -1: grey default
    instances: Instances = field(default_factory=Instances)
    objects: list[Object] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    images: list[Image] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    world: World = field(default_factory=World)
    camera: Camera | None = None
    film: Film = field(default_factory=Film)
