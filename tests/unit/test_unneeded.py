"""What a scene or a render does not need takes no memory and no part in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from scenes import SceneBuilder, background, diffuse, emission, quad, shader

import engine_core

SIZE = 24


def plain(lamps: int = 1) -> SceneBuilder:
    """A matte floor under panels: constant materials, nothing behind them."""
    builder = SceneBuilder((SIZE, SIZE))
    builder.camera((0, -5, 3), (0, 0, 0))
    builder.add(quad((-4, -4, 0), (8, 0, 0), (0, 8, 0)), diffuse(0.5))
    for number in range(lamps):
        builder.light("POINT", emission=(9.0,) * 3, radius=0.1 * (number + 1))
    return builder


def requirements(builder: SceneBuilder) -> Any:
    return engine_core.compile(builder.description, threads=1).requirements


def state_size(passes: list[str], folder: Path) -> int:
    """Bytes of what a film keeps."""
    scene = engine_core.compile(plain().description, threads=1)
    session = engine_core.Session(scene, {"integrator": "PATH"}, passes)
    session.save(str(folder / "state"))
    return (folder / "state").stat().st_size


@pytest.mark.parametrize(
    ("name", "channels"), [("Normal", 3), ("Depth", 1), ("Error", 0), ("Debug Sample Count", 0)]
)
def test_a_pass_takes_memory_only_where_it_is_asked_for(
    name: str, channels: int, tmp_path: Path
) -> None:
    without = state_size(["Combined"], tmp_path)
    assert state_size(["Combined", name], tmp_path) - without == 8 * channels * SIZE**2


def test_a_plain_scene_requires_nothing_but_itself() -> None:
    told = requirements(plain())
    needed = {name for name, value in told.items() if value}
    assert needed == {
        "triangles", "instanced_triangles", "instances", "lamps", "constant_materials",
    }  # fmt: skip


def test_a_light_tree_is_for_several_lights() -> None:
    assert not requirements(plain(1))["light_tree"]
    assert requirements(plain(2))["light_tree"]


def test_each_thing_that_is_added_is_the_only_thing_required() -> None:
    before = requirements(plain())

    def added(builder: SceneBuilder) -> set[str]:
        after = requirements(builder)
        return {name for name in after if bool(after[name]) != bool(before[name])}

    world = plain()
    world.description.world = background(0.2)
    assert added(world) == {"environment"}
    glass = plain()
    clear = shader("ShaderNodeBsdfGlass", Color=(1.0,) * 4, Roughness=0.0, IOR=1.5)
    glass.add(quad((-1, -1, 1), (2, 0, 0), (0, 2, 0)), clear)
    assert added(glass) == {"singular_lobes", "transmission", "caustics"}
    glowing = plain()
    glowing.add(quad((-1, -1, 4), (0, 2, 0), (2, 0, 0)), emission(6.0))
    assert added(glowing) == {"emissive_triangles", "light_tree"}
