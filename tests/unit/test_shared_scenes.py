"""Successive scenes share what an edit left alone, and look as if they had been compiled afresh."""

from __future__ import annotations

import contextlib
import copy
import os
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from engine_core.description import Image, Link, Node, SceneDescription, World
from scenes import SceneBuilder, background, box, diffuse, emission, look_at, quad

import engine_core

SETTINGS = {"samples": 4, "threads": 1}


def room() -> SceneDescription:
    """A floor with a picture on it, an emitting panel, two boxes of one mesh, and a lamp."""
    builder = SceneBuilder((24, 16))
    builder.camera((0, -6, 4), (0, 0, 0), 60.0)
    floor = diffuse(0.7)
    floor.nodes.append(Node("ShaderNodeTexImage", "picture", {}, {"image": 0}))
    floor.nodes[0].inputs["Color"] = Link(1, "Color")
    pixels = np.linspace(0, 255, 48).astype(np.uint8).reshape(4, 4, 3)
    builder.description.images.append(Image("checks", np.ascontiguousarray(pixels)))
    builder.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), floor)
    builder.add(quad((-1, 1, 3), (2, 0, 0), (0, -2, 0)), emission(2.0))
    shape = builder.mesh(box((-0.3, -0.3, 0), (0.3, 0.3, 0.6)))
    red = builder.material(diffuse((0.8, 0.2, 0.1)), "red")
    for x in (-1.0, 1.0):
        place = np.eye(3, 4, dtype=np.float32)
        place[0, 3] = x
        builder.instance(shape, red, place)
    builder.light("POINT", transform=look_at((2, -2, 3), (0, 0, 0)), emission=(30.0, 30.0, 20.0))
    builder.description.world = background(0.2)
    return builder.description


def edited(scene: SceneDescription) -> SceneDescription:
    """A description that shares meshes and images with `scene` and nothing that edits touch."""
    result = copy.copy(scene)
    for name in ("materials", "lights", "world", "material_sets", "instances", "objects"):
        setattr(result, name, copy.deepcopy(getattr(scene, name)))
    result.images, result.meshes = list(scene.images), list(scene.meshes)
    return result


def picture(scene: Any) -> Any:
    session = engine_core.Session(scene, SETTINGS, ["Combined"])
    session.start()
    assert session.wait(60.0)
    assert not session.error_message
    return session.read("Combined", 0, 0, scene.width, scene.height)


def nothing(scene: SceneDescription) -> None:
    pass


def color(scene: SceneDescription) -> None:
    scene.materials[2].graph.nodes[0].inputs["Color"] = (0.1, 0.8, 0.1, 1.0)


def emitted(scene: SceneDescription) -> None:
    scene.materials[1].graph.nodes[0].inputs["Strength"] = 5.0


def transparency(scene: SceneDescription) -> None:
    scene.materials[2].graph.nodes[0].kind = "ShaderNodeBsdfTransparent"


def new_material(scene: SceneDescription) -> None:
    scene.materials.append(replace(scene.materials[2], name="other", graph=diffuse(0.9)))
    scene.material_sets[2] = [3]


def lamp(scene: SceneDescription) -> None:
    scene.lights[0].transform[2, 3] += 1.0


def world(scene: SceneDescription) -> None:
    scene.world = background(1.0)


def no_world(scene: SceneDescription) -> None:
    scene.world = World()


def place(scene: SceneDescription) -> None:
    scene.instances.transform[3, 0, 3] += 0.25


def hidden(scene: SceneDescription) -> None:
    scene.instances.visibility[2] = 0


def image(scene: SceneDescription) -> None:
    pixels = scene.images[0].pixels
    assert pixels is not None
    scene.images[0] = Image("negative", np.ascontiguousarray(255 - pixels))


def mesh(scene: SceneDescription) -> None:
    scene.meshes[2] = box((-0.4, -0.4, 0), (0.4, 0.4, 1.0))


def fewer(scene: SceneDescription) -> None:
    scene.lights.clear()


# The edit, and what is made anew: geometry, lights, materials, images.
EDITS = [
    (nothing, (False, False, 0, 0)),
    (color, (False, False, 1, 0)),
    (emitted, (False, True, 1, 0)),
    (transparency, (True, True, 1, 0)),
    (new_material, (False, True, 2, 0)),  # the default's number has changed, too
    (lamp, (False, True, 0, 0)),
    (world, (False, True, 0, 0)),
    (no_world, (False, True, 0, 0)),
    (place, (True, True, 0, 0)),
    (hidden, (True, True, 0, 0)),
    (image, (False, True, 4, 1)),
    (mesh, (True, True, 0, 0)),
    (fewer, (False, True, 0, 0)),
]


@pytest.mark.parametrize(("edit", "made"), EDITS, ids=[edit.__name__ for edit, _ in EDITS])
def test_an_edit_makes_only_its_own(
    edit: Callable[[SceneDescription], None], made: tuple[bool, bool, int, int]
) -> None:
    before = room()
    first = engine_core.compile(before, interactive=True)
    assert first.compiled["changed"]
    after = edited(before)
    edit(after)
    second = engine_core.compile(after, interactive=True, previous=first)
    parts = second.compiled
    found = tuple(parts[name] for name in ("geometry", "lights", "materials", "images"))
    assert found == made
    assert parts["changed"] == (edit is not nothing)
    del first  # what is shared must live on
    fresh = picture(engine_core.compile(after, interactive=True))
    # Render space may have another origin: then rounding differs.
    np.testing.assert_allclose(picture(second), fresh, rtol=2e-3, atol=1e-5)
    if edit is not nothing:
        assert not np.allclose(picture(engine_core.compile(before)), fresh, rtol=1e-3)


def test_a_chain_of_edits() -> None:
    """What the first scene made serves the last one, after all between are gone."""
    description = room()
    scene = engine_core.compile(description, interactive=True)
    for step in range(20):
        description = edited(description)
        description.materials[2].graph.nodes[0].inputs["Color"] = (step / 20, 0.5, 0.5, 1.0)
        scene = engine_core.compile(description, interactive=True, previous=scene)
        assert scene.compiled["materials"] == 1
    fresh = engine_core.compile(description, interactive=True)
    np.testing.assert_array_equal(picture(scene), picture(fresh))


def test_another_view_shares_everything() -> None:
    description = room()
    scene = engine_core.compile(description, interactive=True)
    other = room()
    assert other.camera is not None
    other.camera.transform = look_at((3, -4, 2), (0, 0, 0.5))
    other.film = replace(other.film, width=30, height=20, crop=(5, 5, 25, 20))
    moved = engine_core.with_view(scene, other.camera, other.film)
    assert (moved.width, moved.height) == (20, 15)
    del scene
    fresh = engine_core.compile(other, interactive=True)
    np.testing.assert_array_equal(picture(moved), picture(fresh))


def test_a_view_must_be_valid() -> None:
    description = room()
    scene = engine_core.compile(description)
    assert description.camera is not None
    camera = replace(description.camera, window=(1.0, -1.0, -1.0, 1.0))
    with pytest.raises(engine_core.DescriptionError, match="window is empty"):
        engine_core.with_view(scene, camera, description.film)


def test_a_scene_that_was_not_interactive_shares_nothing() -> None:
    description = room()
    scene = engine_core.compile(description)
    again = engine_core.compile(description, interactive=True, previous=scene)
    assert again.compiled["geometry"]
    assert again.compiled["changed"]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="single threads have a priority")
@pytest.mark.parametrize("give_way", [False, True])
def test_threads_give_way_when_asked(give_way: bool) -> None:
    def niceness() -> dict[str, int]:
        found = {}
        for task in os.listdir("/proc/self/task"):
            # A thread may end meanwhile: it is then none of the session's.
            with contextlib.suppress(ProcessLookupError):
                found[task] = os.getpriority(os.PRIO_PROCESS, int(task))
        return found

    scene = engine_core.compile(room())
    before = set(niceness())
    usual = os.getpriority(os.PRIO_PROCESS, 0)
    settings = {"samples": 1 << 24, "threads": 2}
    session = engine_core.Session(scene, settings, ["Combined"], give_way=give_way)
    session.start()
    while session.poll().rays == 0:
        assert not session.wait(0.01)
    new = [nice for task, nice in niceness().items() if task not in before]
    session.cancel()
    assert session.wait(60.0)
    assert new.count(max(usual, 10) if give_way else usual) == 2
