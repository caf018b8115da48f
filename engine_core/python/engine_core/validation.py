"""The rules of a scene description, checked whole before it enters the core.

`validate` raises `DescriptionError` with one sentence that names the thing and what is wrong with
it. What it lets pass, the core can compile without reading outside of an array.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from .description import (
    Attribute,
    Camera,
    Domain,
    Film,
    Graph,
    Image,
    Instances,
    Light,
    Link,
    Mesh,
    SceneDescription,
    Visibility,
)


class DescriptionError(ValueError):
    """A scene description that breaks a rule; the message is one sentence for the user."""


# Largest picture side that is accepted; Blender's own limit.
MAX_RESOLUTION = 65536
_INT32_MAX = (1 << 31) - 1

_LIGHT_KINDS = ("POINT", "SPOT", "SUN", "AREA")
_SHAPES = ("RECTANGLE", "ELLIPSE")
_CAMERA_KINDS = ("PERSPECTIVE", "ORTHOGRAPHIC")
_FILTERS = ("BOX", "GAUSSIAN", "BLACKMAN_HARRIS")
_ENCODINGS = ("srgb", "linear")
_ALPHAS = ("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE")


def validate(description: SceneDescription) -> None:
    """Raises DescriptionError unless `description` keeps every rule."""
    try:
        _check(description)
    except DescriptionError:
        raise
    except (TypeError, AttributeError, ValueError, OverflowError, LookupError) as error:
        # A part is of another type than its field says: it cannot even be looked at.
        what = " ".join(str(error).split())
        raise DescriptionError(f"the description is malformed: {what}") from error


def _check(description: SceneDescription) -> None:
    images = len(description.images)
    for mesh in description.meshes:
        _check_mesh(mesh)
    for number, slots in enumerate(description.material_sets):
        _check_material_set(number, slots, len(description.materials))
    for item in description.objects:
        _check_numbers(f'object "{item.name}"', "color", item.color, 4)
        _check_numbers(f'object "{item.name}"', "location", item.location, 3)
        _check_numbers(f'object "{item.name}"', "pass_index", (item.pass_index,), 1)
    _check_instances(description.instances, description)
    for image in description.images:
        _check_image(image)
    for material in description.materials:
        name = f'material "{material.name}"'
        _check_numbers(name, "pass_index", (material.pass_index,), 1)
        check_graph(material.graph, name, images)
    for light in description.lights:
        _check_light(light, images)
    check_graph(description.world.graph, "the world", images)
    _check_visibility("the world", description.world.visibility)
    if description.camera is not None:
        _check_camera(description.camera)
    _check_film(description.film)


def validate_view(camera: Camera, film: Film) -> None:
    """Raises DescriptionError unless the two keep every rule."""
    _check_camera(camera)
    _check_film(film)


def _fail(name: str, what: str) -> None:
    # Values of the wrong type may print as many lines.
    raise DescriptionError(" ".join(f"{name}: {what}".split()))


def _check_array(
    name: str, field: str, array: object, dtype: type[np.generic], shape: Sequence[int | None]
) -> None:
    """Checks dtype, shape (None: any length) and layout."""
    if not isinstance(array, np.ndarray) or array.dtype != dtype:
        found = array.dtype if isinstance(array, np.ndarray) else type(array).__name__
        _fail(name, f"{field} must be an array of {np.dtype(dtype)}, not {found}")
        return
    fits = array.ndim == len(shape) and all(
        want is None or want == have for want, have in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = "(" + ", ".join("n" if n is None else str(n) for n in shape) + ")"
        _fail(name, f"{field} must have shape {wanted}, not {array.shape}")
    if not array.flags.c_contiguous:
        _fail(name, f"{field} must be C-contiguous")
    if not array.flags.aligned:
        _fail(name, f"{field} must be aligned to the size of its numbers")


def _check_finite(name: str, field: str, array: np.ndarray) -> None:
    finite = np.isfinite(array)
    if not finite.all():
        index = int(np.argmin(finite.reshape(-1)))
        row = index // max(1, array[0].size) if array.ndim > 1 else index
        _fail(name, f"{field} is not finite at element {row}")


def _check_range(name: str, field: str, array: np.ndarray, low: int, high: int) -> None:
    """Checks low <= value < high."""
    if array.size and (int(array.min()) < low or int(array.max()) >= high):
        bad = int(np.argmax((array < low) | (array >= high)))
        _fail(name, f"{field} is {array[bad]} at element {bad}, outside of {low} to {high - 1}")


def _check_numbers(name: str, field: str, values: Iterable[float], count: int) -> None:
    numbers = tuple(values)
    if len(numbers) != count:
        _fail(name, f"{field} must have {count} numbers, not {len(numbers)}")
    if not all(_is_number(x) and _is_float32(x) for x in numbers):
        _fail(name, f"{field} must be finite numbers, not {_show(numbers)}")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.integer | np.floating)


def _is_float32(value: float) -> bool:
    """Whether the value stays finite as a 32-bit float, which is what the core holds."""
    return math.isfinite(value) and abs(value) <= float(np.finfo(np.float32).max)


def _show(numbers: tuple[object, ...]) -> str:
    return str(numbers[0]) if len(numbers) == 1 else str(numbers)


def _check_at_least(name: str, field: str, value: float, low: float) -> None:
    _check_numbers(name, field, (value,), 1)
    if value < low:
        _fail(name, f"{field} must be at least {low:g}, not {value:g}")


def _check_whole(name: str, field: str, value: object) -> None:
    if not isinstance(value, int | np.integer) or abs(int(value)) > _INT32_MAX:
        _fail(name, f"{field} must be a whole number of 32 bits, not {value}")


def _check_item(name: str, field: str, value: str, items: Sequence[str]) -> None:
    if value not in items:
        _fail(name, f"{field} must be one of {', '.join(items)}, not {value!r}")


def _check_visibility(name: str, value: int) -> None:
    if not isinstance(value, int) or value & ~int(Visibility.ALL):
        _fail(name, f"visibility must be bits of {int(Visibility.ALL)}, not {value}")


def _check_mesh(mesh: Mesh) -> None:
    name = f'mesh "{mesh.name}"'
    _check_array(name, "positions", mesh.positions, np.float32, (None, 3))
    _check_finite(name, "positions", mesh.positions)
    _check_array(name, "corner_vertices", mesh.corner_vertices, np.int32, (None,))
    _check_range(name, "corner_vertices", mesh.corner_vertices, 0, len(mesh.positions))
    _check_array(name, "face_offsets", mesh.face_offsets, np.int32, (None,))
    corners = len(mesh.corner_vertices)
    offsets = mesh.face_offsets
    if len(offsets) == 0 or offsets[0] != 0 or offsets[-1] != corners:
        _fail(name, f"face_offsets must go from 0 to the number of corners, {corners}")
    _check_range(name, "face_offsets", offsets, 0, corners + 1)
    small = np.diff(offsets) < 3  # no overflow: all lie within 0 to the number of corners
    if small.any():
        _fail(name, f"face {int(np.argmax(small))} has fewer than three corners")
    faces = len(offsets) - 1
    if mesh.face_materials is not None:
        _check_array(name, "face_materials", mesh.face_materials, np.int32, (faces,))
        _check_range(name, "face_materials", mesh.face_materials, 0, 1 << 16)
    elements = {Domain.POINT: len(mesh.positions), Domain.FACE: faces, Domain.CORNER: corners}
    _check_normals(name, mesh, elements)
    seen: set[str] = set()
    for attribute in mesh.attributes:
        _check_attribute(name, attribute, elements)
        if attribute.name in seen:
            _fail(name, f'attribute "{attribute.name}" occurs twice')
        seen.add(attribute.name)
    _check_numbers(name, "texture_space_min", mesh.texture_space_min, 3)
    _check_numbers(name, "texture_space_max", mesh.texture_space_max, 3)


def _check_normals(name: str, mesh: Mesh, elements: dict[Domain, int]) -> None:
    if mesh.normal_domain == Domain.FACE:
        if mesh.normals is not None:
            _fail(name, "normals must be None where normal_domain is FACE")
        return
    if mesh.normal_domain not in elements:
        _fail(name, f"normal_domain {mesh.normal_domain!r} is not known")
    _check_array(name, "normals", mesh.normals, np.float32, (elements[mesh.normal_domain], 3))
    assert mesh.normals is not None
    _check_finite(name, "normals", mesh.normals)


def _check_attribute(name: str, attribute: Attribute, elements: dict[Domain, int]) -> None:
    field = f'attribute "{attribute.name}"'
    if attribute.domain not in elements:
        _fail(name, f"the domain of {field} is not known: {attribute.domain!r}")
    _check_array(name, field, attribute.data, np.float32, (elements[attribute.domain], None))
    if not 1 <= attribute.data.shape[1] <= 4:
        _fail(name, f"{field} must have 1 to 4 channels, not {attribute.data.shape[1]}")
    _check_finite(name, field, attribute.data)


def _check_material_set(number: int, slots: Sequence[int], materials: int) -> None:
    name = f"material set {number}"
    if not slots:
        _fail(name, "has no slot")
    for slot, material in enumerate(slots):
        if not isinstance(material, int) or not -1 <= material < materials:
            _fail(name, f"slot {slot} names material {material} of {materials}")


def _check_instances(instances: Instances, description: SceneDescription) -> None:
    name = "instances"
    count = len(instances.mesh)
    _check_array(name, "mesh", instances.mesh, np.int32, (count,))
    _check_array(name, "transform", instances.transform, np.float32, (count, 3, 4))
    _check_array(name, "visibility", instances.visibility, np.uint32, (count,))
    _check_array(name, "material_set", instances.material_set, np.int32, (count,))
    _check_array(name, "random", instances.random, np.float32, (count,))
    _check_array(name, "object", instances.object, np.int32, (count,))
    _check_range(name, "mesh", instances.mesh, 0, len(description.meshes))
    _check_range(name, "material_set", instances.material_set, 0, len(description.material_sets))
    _check_range(name, "object", instances.object, 0, len(description.objects))
    _check_range(name, "visibility", instances.visibility, 0, int(Visibility.ALL) + 1)
    _check_finite(name, "transform", instances.transform)
    outside = ~((instances.random >= 0.0) & (instances.random < 1.0))
    if outside.any():
        _fail(name, f"random is outside of [0, 1) at element {int(np.argmax(outside))}")


def _check_image(image: Image) -> None:
    name = f'image "{image.name}"'
    _check_item(name, "encoding", image.encoding, _ENCODINGS)
    _check_item(name, "alpha", image.alpha, _ALPHAS)
    pixels = image.pixels
    if pixels is None:
        return
    dtype = np.float32 if pixels.dtype == np.float32 else np.uint8
    _check_array(name, "pixels", pixels, dtype, (None, None, None))
    if pixels.shape[2] not in (1, 3, 4):
        _fail(name, f"pixels must have 1, 3 or 4 channels, not {pixels.shape[2]}")
    if pixels.size == 0:
        _fail(name, "pixels are empty; a missing image has None")
    if dtype == np.float32:
        _check_finite(name, "pixels", pixels)


def check_graph(graph: Graph, name: str, images: int) -> None:
    """Checks links, values, image indices and that no links form a cycle."""
    count = len(graph.nodes)
    if graph.surface is not None and not 0 <= graph.surface.node < count:
        _fail(name, f"the surface is linked to node {graph.surface.node} of {count}")
    for node in graph.nodes:
        where = f'node "{node.name}" ({node.kind})'
        for key, value in node.inputs.items():
            if isinstance(value, Link):
                if not 0 <= value.node < count:
                    _fail(name, f'{where}: input "{key}" is linked to node {value.node} of {count}')
            else:
                numbers = value if isinstance(value, tuple) else (value,)
                if not 1 <= len(numbers) <= 4:
                    _fail(name, f'{where}: input "{key}" must have 1 to 4 numbers')
                _check_numbers(name, f'{where}: input "{key}"', numbers, len(numbers))
        for key, param in node.params.items():
            _check_param(name, f'{where}: "{key}"', key, param, images)
    _check_acyclic(graph, name)


def _check_param(name: str, field: str, key: str, value: object, images: int) -> None:
    if isinstance(value, np.ndarray):
        _check_array(name, field, value, np.float32, (None,))
        _check_finite(name, field, value)
    elif _is_number(value):
        if not math.isfinite(value):  # type: ignore[arg-type]
            _fail(name, f"{field} must be finite, not {value}")
        if key == "image" and not (isinstance(value, int) and -1 <= value < images):
            _fail(name, f"{field} names image {value} of {images}")
    elif not isinstance(value, bool | str):
        _fail(name, f"{field} is a {type(value).__name__}, not a number, a string or an array")


def _check_acyclic(graph: Graph, name: str) -> None:
    """Removes nodes that wait for nothing, over and over (Kahn 1962): what stays is in a cycle."""
    waits = [0] * len(graph.nodes)
    readers: list[list[int]] = [[] for _ in graph.nodes]
    for number, node in enumerate(graph.nodes):
        for value in node.inputs.values():
            if isinstance(value, Link):
                waits[number] += 1
                readers[value.node].append(number)
    ready = [number for number, wait in enumerate(waits) if wait == 0]
    done = 0
    while ready:
        done += 1
        for reader in readers[ready.pop()]:
            waits[reader] -= 1
            if waits[reader] == 0:
                ready.append(reader)
    if done < len(graph.nodes):
        stuck = next(number for number, wait in enumerate(waits) if wait > 0)
        _fail(name, f'links form a cycle at node "{graph.nodes[stuck].name}"')


def _check_transform(name: str, transform: np.ndarray) -> None:
    _check_array(name, "transform", transform, np.float32, (3, 4))
    _check_finite(name, "transform", transform)


def _check_light(light: Light, images: int) -> None:
    name = f'light "{light.name}"'
    _check_item(name, "kind", light.kind, _LIGHT_KINDS)
    _check_item(name, "shape", light.shape, _SHAPES)
    _check_transform(name, light.transform)
    _check_numbers(name, "emission", light.emission, 3)
    for field in ("radius", "spot_angle", "size_x", "size_y", "spread", "sun_angle"):
        _check_at_least(name, field, getattr(light, field), 0.0)
    _check_numbers(name, "spot_blend", (light.spot_blend,), 1)
    if not 0.0 <= light.spot_blend <= 1.0:
        _fail(name, f"spot_blend must lie in [0, 1], not {light.spot_blend:g}")
    _check_visibility(name, light.visibility)
    check_graph(light.graph, name, images)


def _check_camera(camera: Camera) -> None:
    name = "the camera"
    _check_item(name, "kind", camera.kind, _CAMERA_KINDS)
    _check_transform(name, camera.transform)
    _check_numbers(name, "window", camera.window, 4)
    left, right, bottom, top = camera.window
    if not (left < right and bottom < top):
        _fail(name, f"window is empty: {camera.window}")
    _check_numbers(name, "clip_start", (camera.clip_start,), 1)
    _check_numbers(name, "clip_end", (camera.clip_end,), 1)
    if not camera.clip_start < camera.clip_end:
        _fail(name, f"clip_start {camera.clip_start:g} is not below clip_end {camera.clip_end:g}")
    _check_at_least(name, "aperture_radius", camera.aperture_radius, 0.0)
    _check_numbers(name, "focus_distance", (camera.focus_distance,), 1)
    _check_numbers(name, "blade_rotation", (camera.blade_rotation,), 1)
    _check_numbers(name, "aperture_ratio", (camera.aperture_ratio,), 1)
    if not (camera.focus_distance > 0.0 and camera.aperture_ratio > 0.0):
        _fail(name, "focus_distance and aperture_ratio must be positive")
    _check_whole(name, "blades", camera.blades)
    _check_at_least(name, "blades", camera.blades, 0)


def _check_film(film: Film) -> None:
    name = "the film"
    for field in ("width", "height"):
        value = getattr(film, field)
        _check_whole(name, field, value)
        if not 1 <= value <= MAX_RESOLUTION:
            _fail(name, f"{field} must lie in 1 to {MAX_RESOLUTION}, not {value}")
    _check_numbers(name, "crop", film.crop, 4)
    for edge in film.crop:
        _check_whole(name, "crop", edge)
    x0, y0, x1, y1 = film.crop
    if not (0 <= x0 < x1 <= film.width and 0 <= y0 < y1 <= film.height):
        _fail(name, f"crop {film.crop} is empty or outside of {film.width} x {film.height} pixels")
    _check_item(name, "filter", film.filter, _FILTERS)
    _check_at_least(name, "filter_width", film.filter_width, 0.0)
    _check_at_least(name, "exposure", film.exposure, 0.0)
    _check_numbers(name, "pass_alpha_threshold", (film.pass_alpha_threshold,), 1)
    if not 0.0 <= film.pass_alpha_threshold <= 1.0:
        _fail(name, f"pass_alpha_threshold must lie in [0, 1], not {film.pass_alpha_threshold:g}")
