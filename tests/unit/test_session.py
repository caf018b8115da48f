"""Sessions: pictures that depend on the seed alone, cancelling, limits, and reading meanwhile."""

from __future__ import annotations

import gc
import math
import threading
import time
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from engine_core.description import Film
from numpy.typing import NDArray
from scenes import SceneBuilder, background, box, diffuse, emission, placed, quad, shader, sphere

import engine_core

PASSES = [info.name for info in engine_core.passes()]
Pictures = dict[str, NDArray[np.float32]]

#: Generous: what a loaded machine may need to stop some threads.
SOON = 20.0


def room(size: tuple[int, int] = (48, 40), **film: Any) -> Any:
    """A compiled scene with every kind of light path."""
    builder = SceneBuilder(size)
    builder.description.film = Film(*size, **{"crop": (0, 0, *size), **film})
    builder.camera((0, -6, 3), (0, 0, 0.6), aperture_radius=0.05, focus_distance=6.0)
    builder.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse((0.7, 0.5, 0.3)))
    glossy = shader("ShaderNodeBsdfPrincipled", Base_Color=(0.5, 0.6, 0.8, 1.0), Roughness=0.3)
    builder.add(sphere(0.8, (-1, 0, 0.8), rings=12), glossy)
    glass = shader("ShaderNodeBsdfGlass", Color=(1.0, 1.0, 1.0, 1.0), Roughness=0.0, IOR=1.5)
    builder.add(sphere(0.7, (1, -0.5, 0.7), rings=12), glass)
    builder.add(quad((-1, -1, 4), (0, 2, 0), (2, 0, 0)), emission(5.0))
    builder.light("POINT", transform=placed(1.0, (2, -2, 3)), emission=(60.0,) * 3, radius=0.1)
    builder.description.world = background(0.3)
    return engine_core.compile(builder.description, threads=2, keep_uv=True)


def endless() -> Any:
    """A render that ends only when told: use with ENDLESS."""
    return room()


ENDLESS = {"samples": 1 << 24, "threads": 2}


def finished(session: Any) -> Any:
    """Waits for the end."""
    while not session.wait(10.0):
        pass
    assert session.error_message == ""
    return session


def pictures(scene: Any, passes: list[str], **settings: Any) -> Pictures:
    session = engine_core.Session(scene, {"samples": 24, "threads": 2, **settings}, passes)
    session.start()
    finished(session)
    return {name: session.read(name, 0, 0, scene.width, scene.height) for name in passes}


def differing(a: Pictures, b: Pictures) -> list[str]:
    return [name for name in a if not np.array_equal(a[name], b[name], equal_nan=True)]


@pytest.mark.parametrize("integrator", ["PATH", "WHITTED"])
@pytest.mark.parametrize("size", [(8, 8), (80, 70)], ids=["one tile", "several tiles"])
def test_pictures_do_not_depend_on_the_threads(integrator: str, size: tuple[int, int]) -> None:
    scene = room(size)
    settings = {"integrator": integrator, "samples": 60 if size == (8, 8) else 9, "seed": 5}
    first = pictures(scene, PASSES, **settings, threads=1)
    for threads in (2, 5):
        assert not differing(first, pictures(scene, PASSES, **settings, threads=threads)), threads


def test_pictures_depend_on_the_seed() -> None:
    scene = room((16, 16))
    first = pictures(scene, ["Combined"], seed=1)
    assert not differing(first, pictures(scene, ["Combined"], seed=1))
    assert differing(first, pictures(scene, ["Combined"], seed=2))
    assert differing(first, pictures(scene, ["Combined"], seed=2147483647))


def test_asking_for_passes_does_not_change_the_picture() -> None:
    scene = room((16, 16))
    assert not differing(pictures(scene, ["Combined"]), pictures(scene, PASSES))


def test_a_recompiled_scene_gives_the_same_picture() -> None:
    first, again = (pictures(room((16, 16)), PASSES) for _ in range(2))
    assert not differing(first, again)


@pytest.mark.parametrize("crop", [(0, 0, 1, 1), (5, 3, 40, 11), (17, 9, 48, 40), (33, 0, 34, 40)])
def test_a_border_shows_the_same_pixels_as_the_full_frame(crop: tuple[int, ...]) -> None:
    x0, y0, x1, y1 = crop
    # The error of a pixel is relative to the mean of what is rendered, and so it differs.
    names = [name for name in PASSES if name != "Error"]
    full = pictures(room(), names, samples=6)
    part = pictures(room(crop=crop), names, samples=6)
    assert part["Combined"].shape == (y1 - y0, x1 - x0, 4)
    assert not differing({name: full[name][y0:y1, x0:x1] for name in names}, part)


def test_batches_grow_to_a_quarter_of_what_is_rendered() -> None:
    total, sizes = 0, []
    while total < 4096:
        sizes.append(engine_core.probe.batch_samples(total))
        total += sizes[-1]
    assert sizes[:8] == [1] * 8
    assert max(sizes) == 64
    assert all(size & (size - 1) == 0 for size in sizes)
    assert sizes == sorted(sizes)
    reached = np.cumsum([0, *sizes[:-1]])
    assert all(size <= max(1, before / 4) for size, before in zip(sizes, reached, strict=True))


def test_every_pixel_gets_every_sample() -> None:
    scene = room((40, 33))
    for samples in (1, 7, 100):
        counts = pictures(scene, ["Debug Sample Count"], samples=samples)["Debug Sample Count"]
        assert np.all(counts == samples)


def test_progress_tells_what_was_done() -> None:
    scene = room((40, 33))
    session = engine_core.Session(scene, {"samples": 16, "threads": 2}, ["Combined"])
    before = session.poll(True)
    assert (before.samples, before.rays, before.seconds) == (0, 0, 0)
    assert (before.done, before.cancelled) == (False, False)
    assert math.isinf(before.error)
    assert math.isinf(before.seconds_left)
    session.start()
    finished(session)
    after = session.poll(True)
    assert (after.samples, after.samples_target) == (16, 16)
    assert (after.done, after.cancelled, after.non_finite) == (True, False, 0)
    assert after.rays >= 40 * 33 * 16
    assert 0 < after.error < math.inf
    assert after.seconds > 0
    assert after.seconds_left == 0
    assert math.isinf(session.poll().error)
    # Its clock has stopped.
    time.sleep(0.01)
    assert session.poll().seconds == after.seconds


def test_progress_never_goes_back() -> None:
    session = engine_core.Session(room(), {"samples": 400, "threads": 2}, ["Combined"])
    session.start()
    last = session.poll()
    while not session.wait(0.005):
        now = session.poll()
        assert now.samples >= last.samples
        assert now.rays >= last.rays
        assert now.seconds >= last.seconds
        assert now.seconds_left >= 0
        last = now
    assert session.poll().samples == 400


def test_tiles_that_were_taken_cover_the_frame() -> None:
    scene = room((70, 45))
    session = engine_core.Session(scene, {"samples": 5, "threads": 2}, ["Combined"])
    assert session.take_tiles() == []
    session.start()
    seen = np.zeros((45, 70), int)
    done = False
    while not done:
        done = session.wait(0.002)
        for x, y, width, height in session.take_tiles():
            assert 0 <= x < x + width <= 70
            assert 0 <= y < y + height <= 45
            seen[y : y + height, x : x + width] += 1
            assert session.read("Combined", x, y, width, height).shape == (height, width, 4)
    assert seen.min() >= 1
    assert session.take_tiles() == []


def test_the_middle_of_the_picture_comes_first() -> None:
    scene = room((160, 160))
    session = engine_core.Session(scene, {"samples": 1, "threads": 1}, ["Debug Sample Count"])
    session.start()
    while session.poll().samples == 0:
        pass
    session.cancel()
    finished(session)
    counts = session.read("Debug Sample Count", 0, 0, 160, 160)
    assert counts[64:96, 64:96].max() == 1


def test_parts_are_read_as_the_whole() -> None:
    scene = room()
    session = engine_core.Session(scene, {"samples": 8, "threads": 2}, PASSES)
    session.start()
    finished(session)
    for info in engine_core.passes():
        whole = session.read(info.name, 0, 0, scene.width, scene.height)
        assert whole.shape == (scene.height, scene.width, len(info.channels))
        assert whole.dtype == np.float32
        assert np.isfinite(whole).all()  # the error too: there are eight batches
        part = session.read(info.name, 29, 3, 10, 37)
        assert np.array_equal(part, whole[3:40, 29:39])
        assert np.array_equal(session.read(info.legacy_name, 29, 3, 10, 37), part)
        assert session.read(info.name, 5, 5, 0, 3).shape == (3, 0, len(info.channels))
    # An array is its reader's own, and outlives the session.
    kept = session.read("Combined", 0, 0, 4, 4)
    value = kept.copy()
    del session
    gc.collect()
    assert np.array_equal(kept, value)


@pytest.mark.parametrize(
    "rectangle",
    [(-1, 0, 1, 1), (0, -1, 1, 1), (0, 0, 49, 1), (0, 0, 1, 41), (48, 0, 1, 1), (0, 0, -1, 1),
     (0, 0, 1, -1), (2147483647, 0, 1, 1), (1, 1, 2147483647, 2147483647)],
)  # fmt: skip
def test_rectangles_outside_of_the_film_are_refused(rectangle: tuple[int, ...]) -> None:
    session = engine_core.Session(room(), {}, ["Combined"])
    with pytest.raises(ValueError, match="rectangle is not within the film"):
        session.read("Combined", *rectangle)


def test_unknown_passes_are_named() -> None:
    scene = room((4, 4))
    with pytest.raises(ValueError, match="no pass named Mist"):
        engine_core.Session(scene, {}, ["Combined", "Mist"])
    session = engine_core.Session(scene, {}, ["Normal"])
    with pytest.raises(ValueError, match="no pass named Mist"):
        session.read("Mist", 0, 0, 1, 1)
    with pytest.raises(ValueError, match="pass Depth was not asked for"):
        session.read("Depth", 0, 0, 1, 1)
    assert not session.read("Combined", 0, 0, 4, 4).any()  # always there, still empty


def test_a_session_renders_once() -> None:
    session = engine_core.Session(room((4, 4)), {"samples": 1}, ["Combined"])
    session.start()
    with pytest.raises(RuntimeError, match="renders once"):
        session.start()
    finished(session)


def threads_of_this_process() -> int:
    return len(list(Path("/proc/self/task").iterdir()))


def test_cancelling_ends_every_thread() -> None:
    scene = endless()
    before = threads_of_this_process()
    session = engine_core.Session(scene, {**ENDLESS, "threads": 5}, ["Combined"])
    session.start()
    assert not session.wait(0.05)
    session.cancel()
    assert session.wait(SOON)
    progress = session.poll()
    assert progress.done
    assert progress.cancelled
    assert progress.samples < progress.samples_target
    assert progress.seconds_left == 0
    assert np.isfinite(session.read("Combined", 0, 0, scene.width, scene.height)).all()
    del session
    gc.collect()
    assert threads_of_this_process() <= before


def test_cancelling_before_the_start_and_twice() -> None:
    session = engine_core.Session(endless(), ENDLESS, ["Combined"])
    session.cancel()
    session.start()
    assert session.wait(SOON)
    session.cancel()
    assert session.poll().cancelled
    assert session.poll().samples == 0


def test_a_cancelled_render_holds_whole_batches_only() -> None:
    scene = room((64, 64))
    session = engine_core.Session(scene, {**ENDLESS, "threads": 3}, ["Debug Sample Count"])
    session.start()
    while session.poll().samples < 8:
        session.wait(0.005)
    session.cancel()
    assert session.wait(SOON)
    counts = session.read("Debug Sample Count", 0, 0, 64, 64)[..., 0]
    possible = np.cumsum([0] + [1] * 8 + [2] * 4 + [4] * 4 + [8] * 4 + [16] * 4 + [32] * 4)
    possible = np.append(possible, possible[-1] + 64 * np.arange(1, 10_000))
    assert np.isin(counts, possible).all()
    for y in (0, 32):
        for x in (0, 32):
            assert len(np.unique(counts[y : y + 32, x : x + 32])) == 1


def test_a_session_may_be_dropped_while_it_renders() -> None:
    scene = endless()
    before = threads_of_this_process()
    for _ in range(5):
        session = engine_core.Session(scene, ENDLESS, PASSES)
        session.start()
        session.wait(0.01)
        del session
        gc.collect()
    assert threads_of_this_process() <= before


def test_a_scene_lives_as_long_as_its_session() -> None:
    session = engine_core.Session(room((8, 8)), {"samples": 4, "threads": 2}, ["Combined"])
    gc.collect()
    session.start()
    finished(session)
    assert session.read("Combined", 0, 0, 8, 8)[..., :3].any()


def test_the_time_limit_ends_a_render() -> None:
    session = engine_core.Session(endless(), {**ENDLESS, "time_limit": 0.2}, ["Combined"])
    session.start()
    session.wait(0.05)
    assert session.poll().seconds_left <= 0.2
    assert session.wait(SOON)
    progress = session.poll()
    assert progress.done
    assert not progress.cancelled
    assert progress.seconds >= 0.2
    assert progress.samples > 0


def test_the_time_limit_ends_a_tile_that_would_never_end() -> None:
    settings = {"integrator": "WHITTED", "whitted_depth": 64, "threads": 2, "time_limit": 0.05}
    session = engine_core.Session(doubling_recursion(), settings, ["Combined"])
    session.start()
    assert session.wait(SOON)
    progress = session.poll(True)
    assert progress.done
    assert not progress.cancelled
    assert progress.samples == 0
    assert math.isinf(progress.error)


def test_a_pixel_s_error_is_unknown_below_two_batches() -> None:
    scene = room((8, 8))
    assert np.isinf(pictures(scene, ["Error"], samples=1)["Error"]).all()
    assert np.isfinite(pictures(scene, ["Error"], samples=2)["Error"]).all()
    session = engine_core.Session(scene, {}, ["Error"])
    assert np.isinf(session.read("Error", 0, 0, 8, 8)).all()


def test_samples_end_a_render_before_its_time_limit() -> None:
    session = engine_core.Session(
        room((8, 8)), {"samples": 3, "time_limit": 1e9, "threads": 2}, ["Combined"]
    )
    session.start()
    finished(session)
    assert session.poll().samples == 3


def test_several_sessions_render_one_scene_at_once() -> None:
    scene = room((24, 24))
    alone = pictures(scene, ["Combined"], samples=12, seed=3)
    sessions = [
        engine_core.Session(scene, {"samples": 12, "seed": 3, "threads": 2}, ["Combined"])
        for _ in range(3)
    ]
    for session in sessions:
        session.start()
    for session in sessions:
        finished(session)
        assert not differing(alone, {"Combined": session.read("Combined", 0, 0, 24, 24)})


def test_a_session_may_be_read_by_several_threads_while_it_renders() -> None:
    scene = room()
    session = engine_core.Session(scene, {"samples": 200, "threads": 2}, PASSES)
    failures: list[BaseException] = []

    def read() -> None:
        try:
            while not session.poll(True).done:
                for name in PASSES:
                    picture = session.read(name, 3, 2, 40, 35)
                    # The error is infinite where it is not known yet.
                    assert not np.isnan(picture).any(), name
                    assert name == "Error" or np.isfinite(picture).all(), name
                session.take_tiles()
        except BaseException as error:
            failures.append(error)

    readers = [threading.Thread(target=read) for _ in range(3)]
    session.start()
    for reader in readers:
        reader.start()
    for reader in readers:
        reader.join()
    assert not failures
    finished(session)


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


def test_many_sessions_leave_no_memory_behind() -> None:
    size = (256, 256)

    def render_all(count: int) -> None:
        for _ in range(count):
            pictures(room(size), PASSES, samples=1)
        gc.collect()

    render_all(8)  # allocators and libraries have taken what they keep
    before = resident_bytes()
    render_all(30)
    # One film with all passes and its copy of the pictures is 256 * 256 * 4 * (2 * 55 + 14) bytes:
    # thirty that were kept would take a gigabyte.
    assert resident_bytes() - before < 200e6


@pytest.mark.parametrize("threshold", [0.0, 1.0])
@pytest.mark.parametrize("kind", ["ShaderNodeBsdfDiffuse", "ShaderNodeBsdfAnisotropic"])
def test_paths_in_a_room_that_absorbs_nothing_end(kind: str, threshold: float) -> None:
    """Roulette ends no path that carries all it began with: something else must."""
    builder = SceneBuilder((4, 4))
    inputs = {"Color": (1.0,) * 4, "Roughness": 0.0}
    builder.add(box((-1, -1, -1), (1, 1, 1), inward=True), shader(kind, **inputs))
    builder.camera((0, 0, 0.5), (0, 0, 0))
    scene = engine_core.compile(builder.description, threads=1)
    settings = {"samples": 2, "threads": 1, "roulette_threshold": threshold}
    session = engine_core.Session(scene, settings, ["Combined"])
    session.start()
    finished(session)
    progress = session.poll()
    assert progress.samples == 2
    assert progress.non_finite == 0
    # The thousand vertices before the end is forced, and no more than chance gives beyond.
    assert 1024 <= progress.rays / 32 < 2000


def doubling_recursion() -> Any:
    """A scene of which Whitted's method would cast 2^64 rays per sample."""
    builder = SceneBuilder((4, 4))
    glass = shader("ShaderNodeBsdfGlass", Color=(1.0,) * 4, Roughness=0.0, IOR=1.5)
    for height in range(12):
        builder.add(quad((-9, -9, -height), (18, 0, 0), (0, 18, 0)), glass)
    builder.description.world = background(1.0)
    return engine_core.compile(builder.description, threads=1)


def test_a_recursion_that_doubles_at_every_level_is_cancelled() -> None:
    settings = {"integrator": "WHITTED", "whitted_depth": 64, "threads": 2}
    session = engine_core.Session(doubling_recursion(), settings, ["Combined"])
    session.start()
    assert not session.wait(0.05)
    session.cancel()
    assert session.wait(SOON)


def test_a_compiled_scene_may_take_the_meshes_out_of_its_description() -> None:
    builder = SceneBuilder((8, 8))
    builder.camera((0, -5, 3), (0, 0, 0))
    builder.add(sphere(1.0, (0, 0, 0), rings=12), diffuse(0.5))
    builder.description.world = background(1.0)
    kept = engine_core.compile(builder.description, threads=2)
    assert builder.description.meshes
    held = weakref.ref(builder.description.meshes[0].positions)
    consumed = engine_core.compile(builder.description, threads=2, consume=True)
    assert builder.description.meshes == []
    assert held() is None  # nothing keeps the array
    assert not differing(pictures(kept, ["Combined"]), pictures(consumed, ["Combined"]))


def test_cancelling_is_asked_for_while_a_scene_is_compiled() -> None:
    builder = SceneBuilder((8, 8))
    builder.camera((0, -5, 3), (0, 0, 0))
    builder.add(sphere(1.0, (0, 0, 0), rings=12), diffuse(0.5))
    for consume in (False, True):
        with pytest.raises(RuntimeError, match="cancelled"):
            engine_core.compile(builder.description, cancelled=lambda: True, consume=consume)
