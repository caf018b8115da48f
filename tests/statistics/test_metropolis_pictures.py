"""Metropolis methods make the path tracer's pictures, however short the render."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest
from bidirectional_scenes import LIGHTS, MATERIALS, build, scaled
from method_pictures import Builder, MethodPictures
from scenes import SceneBuilder, diffuse, look_at, pictures, placed, quad, render
from statistics_tools import assert_equal_means

import engine_core

METHODS = ["PSSMLT", "MMLT", "MLT"]
SEEDS = 8
SAMPLES = {"PATH": 64, "PSSMLT": 24, "MMLT": 48, "MLT": 48}

SCENES: dict[str, Builder] = {
    **{
        f"material {name}": partial(build, name, "many")
        for name in ("diffuse", "rough_glass", "glass", "diffuse_and_mirror", "half_clear",
                     "principled_coat", "facing", "light_path_diffuse", "backfacing_glass")
    },
    **{
        f"light {name}": partial(build, "principled", name)
        for name in ("point", "point_soft", "spot_hard", "area_spread", "sun", "sun_disk", "sky",
                     "mesh_textured", "no_shadow", "hidden_from_glossy")
    },
    **{
        f"camera {name}": partial(build, "fresnel", "many", name)
        for name in ("focus_blades", "orthographic_focus", "crop", "clipped")
    },
    "sheet": partial(build, "glass", "many", "focus", "facing_sheet"),
    "camera_only": partial(build, "principled", "many", "pinhole", "camera_only"),
}  # fmt: skip


METHOD_PICTURES = MethodPictures(SCENES, SAMPLES, SEEDS)
shots, reference = METHOD_PICTURES.shots, METHOD_PICTURES.reference


def test_scenes_are_named_as_they_are() -> None:
    known = set(MATERIALS) | set(LIGHTS)
    assert all(n.split()[1] in known for n in SCENES if n.split()[0] in ("material", "light"))


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("method", METHODS)
def test_pictures(name: str, method: str) -> None:
    assert_equal_means(reference(name), shots(name, method, max_bounces=5), block=6)


@pytest.mark.parametrize(
    "settings",
    [
        {"separate_direct": 0},
        {"large_steps": 0.9},
        {"large_steps": 0.001, "chain_length": 16},
        {"chain_length": 1},
        {"mis_heuristic": "BALANCE"},
        {"roulette_threshold": 0.0},
    ],
)
@pytest.mark.parametrize("method", METHODS)
def test_settings_leave_the_expectation(method: str, settings: dict[str, Any]) -> None:
    name = "material rough_glass"
    made = shots(name, method, max_bounces=5, **settings)
    assert_equal_means(reference(name), made, block=6)


@pytest.mark.parametrize("bounces", [0, 1, 2])
@pytest.mark.parametrize("method", METHODS)
def test_limits(method: str, bounces: int) -> None:
    name = "material half_clear"
    path = shots(name, "PATH", max_bounces=bounces)
    assert_equal_means(path, shots(name, method, max_bounces=bounces), block=6)


@pytest.mark.parametrize("method", METHODS)
def test_no_start_up_bias(method: str) -> None:
    """One sample per pixel: chains end before they forget where they began."""
    builder = partial(build, "glossy", "mesh", size=(32, 32))
    path = pictures(builder(), 4, samples=256)
    short = pictures(builder(), 64, integrator=method, samples=1)
    assert_equal_means(path, short, block=32)
    assert_equal_means(path, short, block=16)


@pytest.mark.parametrize("method", METHODS)
def test_threads_change_no_more_than_the_order_of_sums(method: str) -> None:
    images = [
        render(build("glass", "many"), integrator=method, samples=8, threads=threads)["Combined"]
        for threads in (1, 2, 5)
    ]
    for image in images[1:]:
        assert (abs(image - images[0]) <= 2 * np.finfo(np.float32).eps * abs(images[0])).all()


def test_whole_paths_pass_what_is_clear() -> None:
    made = session(build("half_clear", "many", size=(4, 4)), integrator="MLT", samples=1)
    assert not any("Multiplexed" in note for note in made.notes)
    limited = session(build("half_clear", "many", size=(4, 4)), integrator="MLT", samples=1,
                      transparent_bounces=3)  # fmt: skip
    assert any("Multiplexed" in note and "limited" in note for note in limited.notes)


def session(builder: SceneBuilder, **settings: Any) -> Any:
    scene = engine_core.compile(builder.description, threads=2)
    made = engine_core.Session(scene, {"threads": 2, **settings}, ["Combined", "Error"])
    made.start()
    assert made.wait(100.0)
    assert made.error_message == ""
    assert made.poll(False).non_finite == 0
    return made


@pytest.mark.parametrize("method", METHODS)
def test_a_black_frame_ends_at_once_and_says_so(method: str) -> None:
    builder = SceneBuilder((64, 64))
    builder.add(quad((-1, -1, 0), (2, 0, 0), (0, 2, 0)), diffuse(0.5))
    builder.light("AREA", transform=placed(1.0, (0, 0, -2)), emission=(5.0,) * 3)
    builder.camera((0, -3, 2), (0, 0, 0))
    made = session(builder, integrator=method, samples=1 << 20)
    assert made.poll(False).samples == 2
    assert any("No light reaches the camera" in note for note in made.notes)
    assert not np.any(made.read("Combined", 0, 0, 64, 64)[..., :3])


@pytest.mark.parametrize("method", METHODS)
def test_one_mutation(method: str) -> None:
    """A pixel of one sample: its chain has no other step than from the seed to one proposal."""
    path = pictures(build("diffuse", "area", size=(1, 1)), 16, samples=256)
    one = pictures(build("diffuse", "area", size=(1, 1)), 64, integrator=method, samples=1)
    assert_equal_means(path, one, block=1)


def one_family() -> SceneBuilder:
    """A floor that a lamp lights off a mirror alone: paths of one length and one technique."""
    scene = SceneBuilder((16, 16))
    scene.add(quad((-1, -1, 0), (2, 0, 0), (0, 2, 0)), diffuse(0.7))
    scene.add(quad((-1, 1.2, 0), (2, 0, 0), (0, 0, 2)), MATERIALS["mirror"])
    lamp = look_at((0, -0.6, 1.0), (0, 1.2, 1.0))
    scene.light("SPOT", transform=lamp, emission=(20.0,) * 3, radius=0.2, spot_angle=0.8)
    scene.camera((0, -3, 2.5), (0, 0, 0), fov=35)
    return scene


@pytest.mark.parametrize("method", METHODS)
def test_one_family_of_paths(method: str) -> None:
    path = pictures(one_family(), SEEDS, samples=512, max_bounces=1)
    made = pictures(one_family(), SEEDS, integrator=method, samples=48, max_bounces=1)
    assert path.mean() > 0
    assert_equal_means(path, made)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("method", METHODS)
def test_scale_leaves_the_picture(method: str, scale: float) -> None:
    plain = shots("material diffuse", method, max_bounces=4)
    small = pictures(scaled(build("diffuse", "many"), scale), SEEDS, integrator=method,
                     samples=SAMPLES[method], max_bounces=4)  # fmt: skip
    assert_equal_means(plain, small, block=6)


@pytest.mark.parametrize("method", METHODS)
def test_one_bright_pixel_beside_darkness(method: str) -> None:
    """Nearly all light is in a corner of the frame, 1e9 times as bright as the rest."""
    builder = SceneBuilder((16, 16))
    for x, strength in ((-2.6, 1e9), (0.6, 1.0)):
        builder.add(quad((x, 0, 0), (2, 0, 0), (0, 2, 0)), diffuse(0.6))
        builder.add(quad((x, 1, 0), (2, 0, 0), (0, 0, 1)), diffuse(0.6))
        builder.light("POINT", transform=placed(1.0, (x + 1, 0.5, 0.5)), emission=(strength,) * 3)
    builder.camera((1.2, 0.4, 6), (1.2, 0.4, 0), fov=28)
    path = pictures(builder, SEEDS, samples=64, max_bounces=4)
    made = pictures(builder, SEEDS, integrator=method, samples=48, max_bounces=4)
    assert np.isfinite(made).all()
    assert_equal_means(path, made, block=16)
    session(builder, integrator=method, samples=4)
