"""Saved states: renders that go on from them are as if they had never stopped."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import Array, SceneBuilder, background, diffuse, emission, quad, shader, sphere

import engine_core
from engine_core import storage

PASSES = ["Combined", "Normal", "Diffuse Direct", "Diffuse Color", "Error"]


def builder(size: int = 40) -> SceneBuilder:
    scene = SceneBuilder((size, size))
    scene.camera((0, -5, 3), (0, 0, 0.3))
    scene.add(quad((-4, -4, 0), (8, 0, 0), (0, 8, 0)), diffuse(0.5))
    glass = shader("ShaderNodeBsdfGlass", Color=(1.0, 1.0, 1.0, 1.0), Roughness=0.0, IOR=1.5)
    scene.add(sphere(0.8, (0, 0, 0.8), rings=12), glass)
    scene.add(quad((-1, -1, 4), (0, 2, 0), (2, 0, 0)), emission(6.0))
    scene.description.world = background(0.2)
    return scene


@pytest.fixture(scope="module")
def scene() -> Any:
    return engine_core.compile(builder().description, threads=2)


def session_of(scene: Any, state: Path | None = None, **settings: Any) -> Any:
    values = {"samples": 64, "threads": 2, **settings}
    return engine_core.Session(scene, values, PASSES, resume=str(state or ""), digest="a scene")


def finished(session: Any) -> Any:
    session.start()
    while not session.wait(10.0):
        pass
    assert session.error_message == ""
    return session


def pictures(session: Any, scene: Any) -> dict[str, Array]:
    return {name: session.read(name, 0, 0, scene.width, scene.height) for name in PASSES}


def assert_equal(a: dict[str, Array], b: dict[str, Array], exactly: bool = True) -> None:
    for name in PASSES:
        if exactly:
            assert np.array_equal(a[name], b[name]), name
        else:  # the order of splats' sums is left to chance
            assert np.allclose(a[name], b[name], rtol=1e-4, atol=1e-6), name


@pytest.mark.parametrize("integrator", ["PATH", "BDPT", "VCM"])
def test_a_tighter_target_gives_the_picture_of_one_render(
    scene: Any, tmp_path: Path, integrator: str
) -> None:
    state = tmp_path / "state"
    # Adaptive sampling spreads samples by the target.
    settings = {"integrator": integrator, "samples": 256, "adaptive": False}
    first = finished(session_of(scene, **settings, target_error=150.0))
    assert first.poll().ending == "target"
    first.save(str(state), "a scene")
    again = finished(session_of(scene, state, **settings, target_error=60.0))
    once = finished(session_of(scene, **settings, target_error=60.0))
    assert again.poll().samples == once.poll().samples > first.poll().samples
    assert again.poll().ending == once.poll().ending
    assert_equal(pictures(again, scene), pictures(once, scene), exactly=integrator == "PATH")


def test_a_cancelled_render_goes_on_where_its_tiles_are(scene: Any, tmp_path: Path) -> None:
    state = tmp_path / "state"
    session = session_of(scene, samples=600)
    session.start()
    while session.poll().samples < 20:
        session.wait(0.005)
    session.cancel()
    assert session.wait(20.0)
    session.save(str(state), "a scene")
    assert session.poll().samples < 600
    again = finished(session_of(scene, state, samples=600))
    once = finished(session_of(scene, samples=600))
    assert_equal(pictures(again, scene), pictures(once, scene))


@pytest.mark.parametrize("integrator", ["PATH", "BDPT"])
def test_a_state_may_be_saved_while_it_renders(scene: Any, tmp_path: Path, integrator: str) -> None:
    state = tmp_path / "state"
    session = session_of(scene, integrator=integrator, samples=300)
    session.start()
    while session.poll().samples < 4:
        session.wait(0.002)
    for _ in range(3):
        session.save(str(state), "a scene")
    again = finished(session_of(scene, state, integrator=integrator, samples=300))
    while not session.wait(10.0):
        pass
    assert_equal(pictures(again, scene), pictures(session, scene), exactly=integrator == "PATH")
    assert [entry.name for entry in tmp_path.iterdir()] == ["state"]


def test_more_samples_than_were_planned_are_new_ones(scene: Any, tmp_path: Path) -> None:
    state = tmp_path / "state"
    finished(session_of(scene, samples=16)).save(str(state), "a scene")
    again = finished(session_of(scene, state, samples=128))
    assert again.poll().samples == 128
    once = finished(session_of(scene, samples=128))
    # As accurate as one render, though of other points.
    assert again.poll(True).error == pytest.approx(once.poll(True).error, rel=0.5)
    first = pictures(finished(session_of(scene, samples=16)), scene)["Combined"]
    assert not np.allclose(pictures(again, scene)["Combined"], first)


def test_what_differs_is_refused(scene: Any, tmp_path: Path) -> None:
    state = tmp_path / "state"
    finished(session_of(scene, samples=2)).save(str(state), "a scene")
    other = engine_core.compile(builder(24).description, threads=2)
    for arguments, text in (
        ({"seed": 1}, "other settings"),
        ({"integrator": "BDPT"}, "other settings"),
        ({"max_bounces": 2}, "other settings"),
    ):
        with pytest.raises(RuntimeError, match=text):
            session_of(scene, state, **arguments)
    with pytest.raises(RuntimeError, match="another size"):
        session_of(other, state)
    with pytest.raises(RuntimeError, match="other passes"):
        engine_core.Session(scene, {}, ["Combined", "UV"], resume=str(state), digest="a scene")
    with pytest.raises(RuntimeError, match="another scene"):
        engine_core.Session(scene, {}, PASSES, resume=str(state), digest="another")


def test_a_damaged_state_is_refused(scene: Any, tmp_path: Path) -> None:
    state = tmp_path / "state"
    finished(session_of(scene, samples=2)).save(str(state), "a scene")
    whole = state.read_bytes()
    rng = np.random.default_rng(1)
    for place in rng.integers(0, len(whole), 12):
        changed = bytearray(whole)
        changed[place] ^= 0x10
        state.write_bytes(changed)
        with pytest.raises(RuntimeError, match="state"):
            session_of(scene, state)
    for size in (0, 5, 30, len(whole) // 2, len(whole) - 1):
        state.write_bytes(whole[:size])
        with pytest.raises(RuntimeError, match="state"):
            session_of(scene, state)
    with pytest.raises(RuntimeError, match="cannot be read"):
        session_of(scene, tmp_path / "none")


def test_a_state_that_cannot_be_written_leaves_nothing(scene: Any, tmp_path: Path) -> None:
    session = finished(session_of(scene, samples=2))
    with pytest.raises(RuntimeError, match="cannot be written"):
        session.save(str(tmp_path / "no folder" / "state"), "")
    with pytest.raises(RuntimeError, match="cannot be written"):
        session.save(str(tmp_path), "")
    assert not [entry for entry in os.listdir(tmp_path.parent) if ".part" in entry]


def test_a_digest_tells_scenes_apart() -> None:
    first, same = (builder().description for _ in range(2))
    assert storage.digest(first) == storage.digest(same)
    same.meshes[0].positions[0, 0] += 1e-3
    assert storage.digest(first) != storage.digest(same)
    assert storage.digest(first) != storage.digest(builder(41).description)
