"""Instances of objects: one pass over the depsgraph that copies what does not outlive it."""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np
from engine_core.description import FloatArray, Visibility

# Plain numbers: operators of enums are slow, and there may be very many objects.
_RAYS = (
    ("visible_camera", int(Visibility.CAMERA)),
    ("visible_diffuse", int(Visibility.DIFFUSE)),
    ("visible_glossy", int(Visibility.GLOSSY)),
    ("visible_transmission", int(Visibility.TRANSMISSION)),
    ("visible_shadow", int(Visibility.SHADOW)),
)


@dataclass(eq=False)
class ObjectUse:
    """What all instances of one object under one parent share."""

    name: str
    owner: bpy.types.Object  # evaluated; it and its data are valid as long as the depsgraph
    data: bpy.types.Mesh
    mesh_key: tuple[int | str, ...]
    materials: tuple[bpy.types.Material | None, ...]
    visibility: int
    color: tuple[float, float, float, float]
    location: tuple[float, float, float]
    pass_index: float
    shadow_catcher: bool
    holdout: bool


@dataclass
class LampUse:
    """A lamp at a place; `item` is valid as long as the depsgraph is."""

    item: bpy.types.Object
    matrix: FloatArray
    visibility: int


@dataclass
class Collected:
    """Rows of instances (of `uses[use[i]]`), and lamps."""

    uses: list[ObjectUse] = field(default_factory=list)
    use: list[int] = field(default_factory=list)
    matrices: list[float] = field(default_factory=list)
    random: list[float] = field(default_factory=list)
    lamps: list[LampUse] = field(default_factory=list)


def collect(depsgraph: bpy.types.Depsgraph) -> Collected:
    """Visits all visible instances of meshes (what else has faces arrives as meshes) and lamps."""
    result = Collected()
    known: dict[tuple[int, int, int], int] = {}
    owners = _MeshKeys(depsgraph)
    for instance in depsgraph.object_instances:
        item = instance.object
        kind = item.type
        if kind not in ("MESH", "LIGHT") or not instance.show_self:
            continue
        is_instance = instance.is_instance
        parent = instance.parent if is_instance else item
        source = instance.instance_object if is_instance else item
        if kind == "LIGHT":
            visibility = ray_visibility(item)
            result.lamps.append(LampUse(source or item, rows(instance.matrix_world), visibility))
            continue
        data = item.data
        key = ((source or item).as_pointer(), data.as_pointer(), parent.as_pointer())
        if key not in known:
            known[key] = len(result.uses)
            result.uses.append(_object_use(item, source or item, parent, data, owners, depsgraph))
        number = known[key]
        if not result.uses[number].visibility:
            continue
        result.use.append(number)
        matrix = instance.matrix_world
        result.matrices += (*matrix[0], *matrix[1], *matrix[2])
        hashed = instance.random_id & 0xFFFFFFFF if is_instance else name_hash(item.name)
        result.random.append(hashed / 0xFFFFFFFF)
    return result


def rows(matrix: object) -> FloatArray:
    """The first three rows of a 4x4 matrix."""
    return np.ascontiguousarray(np.array(matrix, np.float32)[:3])


def ray_visibility(item: bpy.types.Object) -> int:
    """Visibility bits of an object's own options."""
    bits = 0
    for name, bit in _RAYS:
        if getattr(item, name):
            bits |= bit
    return bits


def _object_use(
    item: bpy.types.Object,
    source: bpy.types.Object,
    parent: bpy.types.Object,
    data: bpy.types.Mesh,
    keys: _MeshKeys,
    depsgraph: bpy.types.Depsgraph,
) -> ObjectUse:
    layer = depsgraph.view_layer_eval
    visibility = ray_visibility(item)
    if parent != item:
        visibility &= ray_visibility(parent)
    holdout = bool(parent.holdout_get(view_layer=layer))
    if not holdout and parent.indirect_only_get(view_layer=layer):
        visibility &= ~int(Visibility.CAMERA)
    return ObjectUse(
        name=item.name,
        owner=source,
        data=data,
        mesh_key=keys.of(source, data),
        materials=materials_of(item, data),
        visibility=visibility,
        color=(*map(float, item.color),),  # type: ignore[arg-type]
        location=(*map(float, item.matrix_world.translation),),  # type: ignore[arg-type]
        pass_index=float(item.pass_index),
        shadow_catcher=bool(item.is_shadow_catcher or parent.is_shadow_catcher),
        holdout=holdout,
    )


def materials_of(
    item: bpy.types.Object, data: bpy.types.Mesh
) -> tuple[bpy.types.Material | None, ...]:
    """The evaluated materials by slot: the mesh's, or the object's where a slot links to it."""
    slots = item.material_slots
    result = list(data.materials)
    for index, slot in enumerate(slots):
        if index >= len(result):
            result.append(slot.material)
        elif slot.link == "OBJECT":
            result[index] = slot.material
    return tuple(result) or (None,)


class _MeshKeys:
    """Keys under which meshes are kept: by their datablock, or by the object that modifies it."""

    def __init__(self, depsgraph: bpy.types.Depsgraph) -> None:
        self._scene = depsgraph.scene
        self._mode = "RENDER" if depsgraph.mode == "RENDER" else "PREVIEW"
        self._parts: dict[int, dict[int, int]] = {}

    def of(self, item: bpy.types.Object, data: bpy.types.Mesh) -> tuple[int | str, ...]:
        """The key of `data`, which the object `item` (evaluated) brought forth."""
        owner = item.original
        base = owner.data
        if isinstance(base, bpy.types.Mesh) and not owner.is_modified(self._scene, self._mode):
            return ("mesh", base.session_uid)
        parts = self._parts.setdefault(owner.session_uid, {})
        part = parts.setdefault(data.as_pointer(), len(parts))
        uids = [owner.session_uid] + ([base.session_uid] if base is not None else [])
        return ("object", *uids, f"part {part}")


def name_hash(name: str) -> int:
    """Object Info's random of an object that is no instance, 32 bits: of its name, as in Cycles.

    The string hash is i * 37 + c; the mixing is `final` of Bob Jenkins' lookup3 (public domain).
    """
    text = 0
    for byte in name.encode():
        text = (text * 37 + byte) & 0xFFFFFFFF
    return _hash_pair(text, 0)


def _hash_pair(first: int, second: int) -> int:
    c = (0xDEADBEEF + (2 << 2) + 13) & 0xFFFFFFFF
    a, b = (c + first) & 0xFFFFFFFF, (c + second) & 0xFFFFFFFF
    c = _mix(c, b, 14)
    a = _mix(a, c, 11)
    b = _mix(b, a, 25)
    c = _mix(c, b, 16)
    a = _mix(a, c, 4)
    b = _mix(b, a, 14)
    return _mix(c, b, 24)


def _mix(target: int, source: int, turn: int) -> int:
    rotated = (source << turn) | (source >> (32 - turn))
    return ((target ^ source) - rotated) & 0xFFFFFFFF
