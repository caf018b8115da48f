"""Two phases: depsgraph updates mark what changed, then one pass applies.

What is kept between passes: meshes, images and material graphs. Everything else is cheap to read.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from engine_core.description import (
    Camera,
    Graph,
    Image,
    Instances,
    Light,
    Material,
    Mesh,
    Object,
    SceneDescription,
    World,
)
from mathutils import Matrix

from ..materials.reads import AttributeRead, attribute_reads
from ..materials.translate import translate
from .camera import Frame, read_camera
from .film import read_film
from .id_map import IdMap
from .images import ImageTable
from .lights import read_light
from .mesh import read_mesh
from .objects import Collected, LampUse, ObjectUse, collect
from .report import Report
from .world import read_world, uses_nodes


@dataclass(frozen=True)
class SyncOptions:
    """What the description takes from the engine's settings and the caller."""

    filter: str = "BLACKMAN_HARRIS"
    filter_width: float = 1.5  # pixels
    exposure: float = 1.0
    border: bool = True
    keep_uv: bool = False  # the UV pass reads every mesh's active UV map
    camera: bpy.types.Object | None = None  # evaluated; None: the scene's
    camera_matrix: Matrix | None = None  # None: the camera object's


class SceneSync:
    """Makes descriptions of one scene, again and again, at the price of what changed."""

    def __init__(self) -> None:
        self._meshes: IdMap[Mesh | None] = IdMap()
        self._images: IdMap[Image] = IdMap()
        self.report = Report()

    def mark(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Phase 1: forgets what the depsgraph's updates say has changed."""
        geometry: set[int] = set()
        images: set[int] = set()
        for update in depsgraph.updates:
            item = update.id.original
            if isinstance(item, bpy.types.Image):
                images.add(item.session_uid)
            elif update.is_updated_geometry:
                geometry.add(item.session_uid)
                data = getattr(item, "data", None)
                if data is not None:
                    geometry.add(data.session_uid)
        self._meshes.mark(geometry)
        self._images.mark(images)

    def apply(
        self, depsgraph: bpy.types.Depsgraph, options: SyncOptions = SyncOptions()
    ) -> SceneDescription:
        """Phase 2: reads the scene; messages of this pass are in `report` afterwards."""
        self.report = Report()
        self._meshes.begin()
        self._images.begin()
        description = _Pass(self, depsgraph, options).run()
        self._meshes.end()
        self._images.end()
        return description


class _Pass:
    """One pass over a depsgraph."""

    def __init__(
        self, sync: SceneSync, depsgraph: bpy.types.Depsgraph, options: SyncOptions
    ) -> None:
        self.scene: bpy.types.Scene = depsgraph.scene_eval
        self.layer: bpy.types.ViewLayer = depsgraph.view_layer_eval
        self.depsgraph = depsgraph
        self.options = options
        self.report = sync.report
        self.meshes = sync._meshes
        self.images = ImageTable(sync._images, self.scene.frame_current, self.report)
        self.materials: list[Material] = []
        self.reads: list[frozenset[AttributeRead]] = []
        self.material_index: dict[int, int] = {}

    def run(self) -> SceneDescription:
        frame = Frame.of(self.scene.render)
        result = SceneDescription(camera=self._camera(frame), world=self._world())
        options = self.options
        result.film = read_film(self.scene, self.layer, frame, options.border)
        result.film.filter = options.filter
        result.film.exposure = options.exposure
        result.film.filter_width = options.filter_width
        collected = collect(self.depsgraph)
        if self.layer.use_solid:
            self._add_objects(collected, result)
        result.lights = self._lights(collected.lamps)
        result.materials = self.materials
        result.images = self.images.images
        return result

    def _camera(self, frame: Frame) -> Camera | None:
        item = self.options.camera or self.scene.camera
        if item is None or item.type != "CAMERA":
            return None
        item = item.evaluated_get(self.depsgraph)
        matrix = self.options.camera_matrix or item.matrix_world
        return read_camera(item, matrix, frame, self.report)

    def _world(self) -> World:
        world = getattr(self.layer, "world_override", None) or self.scene.world
        if world is None or not self.layer.use_sky:
            return World()
        return read_world(world, self.images.index, self.report.warn)

    def _material(self, material: bpy.types.Material | None) -> int:
        """The material's index; -1 for none."""
        material = self.layer.material_override or material
        if material is None:
            return -1
        key = material.original.session_uid
        if key not in self.material_index:
            self.material_index[key] = len(self.materials)
            graph = self._graph(material)
            self.materials.append(Material(material.name, graph, float(material.pass_index)))
            self.reads.append(attribute_reads(graph))
        return self.material_index[key]

    def _graph(self, material: bpy.types.Material) -> Graph:
        name = f'material "{material.name}"'
        if material.node_tree is not None and uses_nodes(material):
            return translate(
                material, material.node_tree, name, self.images.index, self.report.warn
            )
        return plain_diffuse(tuple(float(x) for x in material.diffuse_color))

    def _add_objects(self, collected: Collected, result: SceneDescription) -> None:
        """Numbers meshes and material sets, reads the meshes, and fills the rows of instances."""
        sets: dict[tuple[int, ...], int] = {}
        use_sets = []
        reads: dict[tuple[int | str, ...], frozenset[AttributeRead]] = {}
        for use in collected.uses:
            slots = tuple(self._material(material) for material in use.materials)
            use_sets.append(sets.setdefault(slots, len(sets)))
            needed = frozenset().union(*(self.reads[i] for i in slots if i >= 0))
            if self.options.keep_uv:
                needed |= {AttributeRead("uv", "")}
            reads[use.mesh_key] = reads.get(use.mesh_key, frozenset()) | needed
        result.material_sets = [list(slots) for slots in sets]
        result.objects = [_object(use) for use in collected.uses]

        numbers: dict[tuple[int | str, ...], int] = {}
        for use in collected.uses:
            if use.visibility and use.mesh_key not in numbers:
                mesh = self._mesh(use, reads[use.mesh_key])
                numbers[use.mesh_key] = -1 if mesh is None else len(result.meshes)
                if mesh is not None:
                    result.meshes.append(mesh)
        use_meshes = [numbers.get(use.mesh_key, -1) for use in collected.uses]
        self._fill_instances(collected, use_meshes, use_sets, result)

    def _mesh(self, use: ObjectUse, reads: frozenset[AttributeRead]) -> Mesh | None:
        slots = len(use.materials)
        # A mesh read for other materials may lack attributes: what was read is part of the key.
        key = (*use.mesh_key, f"{slots} slots", repr(sorted(reads)))
        return self.meshes.get(key, lambda: self._read_mesh(use, reads, slots))

    def _read_mesh(
        self, use: ObjectUse, reads: frozenset[AttributeRead], slots: int
    ) -> Mesh | None:
        if not use.data.is_editmode:
            return read_mesh(use.data, use.name, reads, slots, self.report)
        # In edit mode the mesh itself is empty: Blender fills a copy of it when asked.
        mesh = use.owner.to_mesh(preserve_all_data_layers=True, depsgraph=self.depsgraph)
        try:
            return read_mesh(mesh, use.name, reads, slots, self.report)
        finally:
            use.owner.to_mesh_clear()

    def _fill_instances(
        self,
        collected: Collected,
        use_meshes: list[int],
        use_sets: list[int],
        result: SceneDescription,
    ) -> None:
        use = np.array(collected.use, np.int32)
        mesh = np.array(use_meshes, np.int32)[use] if len(use) else np.zeros(0, np.int32)
        matrices = np.array(collected.matrices, np.float64).reshape(-1, 3, 4)
        visible = np.array([item.visibility for item in collected.uses], np.uint32)
        keep = mesh >= 0
        finite = np.isfinite(matrices.astype(np.float32)).all(axis=(1, 2))
        for number in np.unique(use[keep & ~finite]):
            name = collected.uses[number].name
            self.report.warn(f'object "{name}": its transform is not finite; it is left out')
        keep &= finite
        use = use[keep]
        random = np.array(collected.random, np.float32)[keep]
        result.instances = Instances(
            mesh=mesh[keep],
            transform=np.ascontiguousarray(matrices[keep], np.float32),
            visibility=visible[use] if len(use) else np.zeros(0, np.uint32),
            material_set=np.array(use_sets, np.int32)[use] if len(use) else use,
            random=np.minimum(random, np.nextafter(np.float32(1.0), np.float32(0.0))),
            object=use,
        )

    def _lights(self, lamps: list[LampUse]) -> list[Light]:
        graphs: dict[int, Graph] = {}
        result = []
        for lamp in lamps:
            data = lamp.item.data
            key = data.original.session_uid
            if key not in graphs:
                graphs[key] = self._light_graph(data)
            if not np.isfinite(lamp.matrix).all():
                name = lamp.item.name
                self.report.warn(f'light "{name}": its transform is not finite; it is left out')
                continue
            light = read_light(lamp.item, lamp.matrix, lamp.visibility, graphs[key], self.report)
            if light is not None:
                result.append(light)
        return result

    def _light_graph(self, data: bpy.types.Light) -> Graph:
        if data.node_tree is None or not uses_nodes(data):
            return Graph()
        name = f'light "{data.name}"'
        return translate(data, data.node_tree, name, self.images.index, self.report.warn)


def _object(use: ObjectUse) -> Object:
    return Object(
        use.name, use.color, use.location, use.pass_index, use.shadow_catcher, use.holdout
    )


def plain_diffuse(color: tuple[float, ...]) -> Graph:
    """A material without nodes: diffuse in its viewport colour, as in Cycles."""
    from engine_core.description import Link, Node

    node = Node("ShaderNodeBsdfDiffuse", "color", {"Color": color, "Roughness": 0.0})
    return Graph([node], Link(0, "BSDF"))
