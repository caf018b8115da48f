"""`Auto`: what it chooses, when it tries, and what it says."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from engine_core.description import Visibility
from scenes import SceneBuilder, box, diffuse, emission, quad, shader, soft_scene, sphere

import engine_core


def soft(size: int = 96) -> Any:
    """Nothing that a path from a lamp would find sooner."""
    return engine_core.compile(soft_scene(size).description, threads=2)


def fixture(size: int = 96, visibility: int = Visibility.ALL) -> Any:
    """A small lamp within glass: only paths from the lamp light the floor."""
    builder = SceneBuilder((size, size))
    builder.camera((0, -5, 3), (0, 0, 0.3))
    builder.add(quad((-4, -4, 0), (8, 0, 0), (0, 8, 0)), diffuse(0.5))
    glass = shader("ShaderNodeBsdfGlass", Color=(1.0, 1.0, 1.0, 1.0), Roughness=0.0, IOR=1.5)
    builder.add(sphere(0.5, (0, 0, 1.5), rings=16), glass, visibility=visibility)
    builder.add(quad((-0.02, -0.02, 1.5), (0, 0.04, 0), (0.04, 0, 0)), emission(5000.0))
    return engine_core.compile(builder.description, threads=2)


def gap(size: int = 96) -> Any:
    """A room lit through a narrow gap by the light of another."""
    builder = SceneBuilder((size, size))
    builder.camera((-1.5, -1.9, 1.3), (0.8, 0, 1.0))
    builder.add(box((-2, -2, 0), (2, 2, 2.5), inward=True), diffuse(0.7))
    builder.add(quad((-2, 0, 0), (3.97, 0, 0), (0, 0, 2.5)), diffuse(0.7))
    builder.add(quad((-1.8, 1.9, 2.0), (0.2, 0, 0), (0, 0, 0.2)), emission(900.0))
    return engine_core.compile(builder.description, threads=2)


def waves(size: int = 96) -> Any:
    """A floor seen through waves of glass, and lit through them by a small lamp far above."""
    builder = SceneBuilder((size, size))
    builder.camera((0, -4, 3), (0, 0, 0))
    builder.add(quad((-2, -2, 0), (4, 0, 0), (0, 4, 0)), diffuse(0.5))
    glass = shader("ShaderNodeBsdfGlass", Color=(1.0, 1.0, 1.0, 1.0), Roughness=0.0, IOR=1.33)
    heights = [0.8 + 0.3 * math.sin(2.1 * k) for k in range(9)]
    for k, height in enumerate(heights[:-1]):
        slope = heights[k + 1] - height
        builder.add(quad((0.5 * k - 2, -2, height), (0.5, 0, slope), (0, 4, 0)), glass)
    builder.add(quad((-0.02, -0.02, 6), (0, 0.04, 0), (0.04, 0, 0)), emission(2e5))
    return engine_core.compile(builder.description, threads=2)


def plates(size: int = 96) -> Any:
    """Small lamps in plates that hardly blur them: highlights are rare in a pixel, and bright."""
    builder = SceneBuilder((size, size))
    builder.camera((0, -6, 2), (0, 0, 1))
    builder.add(quad((-4, -4, 0), (8, 0, 0), (0, 8, 0)), diffuse(0.3))
    for k, roughness in enumerate((0.02, 0.1, 0.2)):
        plate = shader("ShaderNodeBsdfAnisotropic", Color=(0.8, 0.8, 0.8, 1.0), Roughness=roughness)
        builder.add(quad((-1.5, 0.6 * k, 0.4 + 0.5 * k), (3, 0, 0), (0, 0.4, 0.4)), plate)
    for k, (radius, power) in enumerate(((0.02, 2e3), (0.05, 300.0), (0.2, 20.0))):
        builder.add(sphere(radius, (k - 1, 2.5, 3.2), rings=8), emission(power))
    return engine_core.compile(builder.description, threads=2)


def auto(scene: Any, passes: tuple[str, ...] = ("Combined",), **settings: Any) -> Any:
    """A session that has been started, has chosen, and is not wanted any longer."""
    session = engine_core.Session(
        scene, {"integrator": "AUTO", "threads": 2, **settings}, list(passes)
    )
    session.start()
    while not session.choice and not session.wait(0.01):
        pass
    session.cancel()
    while not session.wait(1.0):
        pass
    assert session.error_message == ""
    return session


def test_auto_is_what_users_begin_with() -> None:
    row = next(row for row in engine_core.parameters() if row.name == "integrator")
    assert row.default == "AUTO"


def test_ordinary_light_is_traced_from_the_camera() -> None:
    session = auto(soft(), samples=1024)
    assert session.integrator == "PATH"
    assert session.choice.startswith("Path tracing: ")
    assert "times bidirectional path tracing" in session.choice


def test_a_lamp_within_glass_is_traced_from_both_ends() -> None:
    session = auto(fixture(), samples=1024)
    assert session.integrator == "BDPT"
    assert "times path tracing" in session.choice
    # The ratio is that of times: it says how much longer path tracing takes.
    assert float(session.choice.split(": ")[1].split(" times")[0]) > 2.0


def test_light_through_a_gap_is_explored_by_chains() -> None:
    scene = gap()
    session = auto(scene, samples=2048)
    assert session.integrator == "MLT", session.choice
    assert session.choice.startswith("Metropolis light transport: ")
    # Not where they would leave something out.
    assert auto(scene, ("Combined", "DiffInd"), samples=2048).integrator != "MLT"
    assert auto(scene, samples=2048, clamp_indirect=10.0).integrator != "MLT"
    assert auto(scene, samples=8).integrator != "MLT"


def test_caustics_that_are_met_by_single_paths_are_explored_by_chains() -> None:
    session = auto(waves(), samples=2048)
    assert session.integrator == "MLT", session.choice
    assert "it looks for caustics first" in session.choice


def test_highlights_are_no_caustics_to_look_for() -> None:
    scene = plates()
    for seed in (1, 2, 3):
        assert auto(scene, samples=2048, seed=seed).integrator != "MLT"


def test_equal_seeds_give_equal_choices() -> None:
    scene = soft()
    reasons = {auto(scene, samples=1024, threads=threads).choice for threads in (1, 2, 3)}
    assert len(reasons) == 1


def test_a_short_render_tries_nothing_and_takes_the_robust_method() -> None:
    assert auto(soft(16), samples=8).integrator == "PATH"
    session = auto(fixture(16), samples=8)
    assert session.integrator == "BDPT"
    assert "too short" in session.choice


def test_too_little_time_tries_nothing_for_long() -> None:
    session = auto(fixture(), samples=1 << 24, time_limit=0.02)
    assert session.integrator == "BDPT"
    assert "too little time" in session.choice


def test_a_viewport_waits_for_nothing() -> None:
    session = engine_core.Session(
        fixture(), {"integrator": "AUTO", "threads": 2}, ["Combined"], give_way=True
    )
    assert session.integrator == "PATH"


def test_limits_by_kind_leave_both_methods() -> None:
    assert auto(fixture(), samples=1024, glossy_bounces=3).integrator == "BDPT"


def test_uneven_visibility_leaves_one_method() -> None:
    session = auto(fixture(visibility=Visibility.ALL & ~Visibility.DIFFUSE), samples=1024)
    assert session.integrator == "PATH"
    assert "the only method" in session.choice


def test_the_pilot_is_part_of_the_run_and_ends_when_it_is_cancelled() -> None:
    session = engine_core.Session(
        fixture(256), {"integrator": "AUTO", "threads": 2, "samples": 1 << 24}, ["Combined"]
    )
    assert session.integrator == "AUTO"
    assert session.choice == ""
    assert session.notes == []
    session.start()
    session.cancel()
    assert session.wait(20.0)
    progress = session.poll(True)
    assert progress.ending == "cancel"
    assert progress.samples == 0
    # What it would have shown is not known, and no picture is made up.
    assert not session.read("Combined", 0, 0, 256, 256).any()


def test_a_render_that_was_stopped_while_trying_begins_anew(tmp_path: Path) -> None:
    scene, settings = soft(), {"integrator": "AUTO", "threads": 2, "samples": 256}
    session = engine_core.Session(scene, settings, ["Combined"])
    session.save(str(tmp_path / "state"), "a scene")
    resumed = engine_core.Session(
        scene, settings, ["Combined"], resume=str(tmp_path / "state"), digest="a scene"
    )
    assert resumed.integrator == "AUTO"
    resumed.start()
    while not resumed.wait(1.0):
        pass
    assert resumed.integrator == "PATH"
    assert resumed.poll().samples == 256


def test_a_named_method_is_not_questioned() -> None:
    session = engine_core.Session(soft(16), {"integrator": "LIGHT", "threads": 2}, ["Combined"])
    assert session.integrator == "LIGHT"
    assert session.choice == ""
