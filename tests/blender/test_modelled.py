"""What a scene required, in words, in the log and in the panel's source."""

from __future__ import annotations

from typing import Any

from scenes import SceneBuilder, diffuse, emission, quad, soft_scene

import engine_core
from addon.modelled import describe


def requirements(builder: SceneBuilder) -> Any:
    return engine_core.compile(builder.description, threads=1).requirements


def plain() -> SceneBuilder:
    builder = SceneBuilder((8, 8))
    builder.camera((0, -5, 3), (0, 0, 0))
    builder.add(quad((-4, -4, 0), (8, 0, 0), (0, 8, 0)), diffuse(0.5))
    builder.add(quad((-1, -1, 4), (0, 2, 0), (2, 0, 0)), emission(6.0))
    return builder


def test_what_a_plain_scene_does_not_need_is_left_out() -> None:
    told = describe(requirements(plain()), 40, 1 << 20, ["Combined"])
    present, left_out = "; ".join(told.present), "; ".join(told.left_out)
    assert "4 triangles" in present
    assert "2 glowing triangles" in present
    for word in ("programs", "world", "lens", "instancing", "caustics"):
        assert word in left_out
    assert "320.0 MiB" in left_out
    assert told.lines()[0].startswith("Modelled: 4 triangles; ")


def test_every_requirement_is_told_once() -> None:
    every: dict[str, Any] = dict.fromkeys(requirements(soft_scene(8)), 3)
    told = describe(every, 0, 64, ["Combined", "Error"])
    assert told.left_out == ()
    assert told.lines()[1] == "Left out: nothing."
    assert "the passes Error" in told.present
    assert len(set(told.present)) == len(told.present)
