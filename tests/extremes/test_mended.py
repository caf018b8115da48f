"""One test for each defect that the suite of extremes found, in the least scene that shows it."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from bidirectional_scenes import lamp, room
from extreme_cases import shapes
from extreme_cases.brightness import shining
from extreme_cases.furnaces import furnace, unlimited
from extreme_cases.lights import lit
from extreme_cases.place import baked, far_corner, moved
from extreme_cases.shadows import closed
from scenes import SceneBuilder, box, diffuse, picture, pictures, placed, quad
from statistics_tools import assert_equal_means, assert_mean_is

import engine_core


@pytest.mark.parametrize("bounces", [0, 100])
def test_what_float32_cannot_hold_is_no_sample_lost(bounces: int) -> None:
    """Two sub-paths may carry light whose product is 0: the guess at it was divided by itself."""
    scene = furnace(0.5, 0.5) if bounces else shining(1e-30)
    settings = unlimited(bounces) if bounces else {"max_bounces": 4}
    # `picture` asserts that nothing was dropped.
    assert picture(scene, integrator="BDPT", samples=4, **settings).mean() > 0


def test_limited_paths_are_not_ended_by_chance() -> None:
    """Chance used to end paths after 1024 surfaces whether or not a limit did."""
    bounces = 3000
    images = pictures(furnace(1.0, 1.0 / (bounces + 2), size=2), 8, samples=2, **unlimited(bounces))
    assert_mean_is(images.mean(axis=(1, 2)), 1.0, tolerance=1e-3)


def test_the_largest_limit_ends_paths() -> None:
    """Paths count their bounces in 16 bits: a limit beyond those would never be reached."""
    settings = {**unlimited(1 << 16), "transparent_bounces": 1 << 16}
    assert np.isfinite(picture(furnace(1.0, 1e-5, size=1), samples=1, **settings)).all()


@pytest.mark.parametrize("kind", ["box", "sphere"])
def test_joined_paths_do_not_pass_through_walls(kind: str) -> None:
    """A segment along a wall used to start on one side of it and to end on the other."""
    scene = closed(kind, 1.0, 0.0)
    assert picture(scene, integrator="BDPT", samples=128, max_bounces=3).max() == 0.0


def soft_lamp_around_things() -> SceneBuilder:
    """A soft lamp's disk turns to whom it lights: a box within its radius shades some of it."""
    scene = SceneBuilder((12, 12))
    scene.add(quad((-2, -2, 0), (4, 0, 0), (0, 4, 0)), diffuse(0.7))
    scene.add(box((0.1, -0.3, 0.5), (0.25, 0.3, 1.0)), diffuse(0.0))
    scene.add(quad((-0.3, -0.4, 1.05), (0.5, 0, 0), (0, 0.8, 0)), diffuse(0.0))
    scene.light("POINT", transform=placed(1.0, (0, 0, 0.8)), emission=(40.0,) * 3, radius=0.5)
    scene.camera((0, -4.0, 3.0), (0, 0, 0), fov=45)
    return scene


@pytest.mark.parametrize("integrator", ["LIGHT", "BDPT"])
def test_light_of_soft_lamps_is_shaded_from_its_start(integrator: str) -> None:
    """Paths from the lamp used to start in the middle of their way from its disk."""
    shots = partial(pictures, soft_lamp_around_things(), 8, max_bounces=0)
    assert_equal_means(shots(samples=256), shots(samples=256, integrator=integrator))


@pytest.mark.parametrize("integrator", ["LIGHT", "BDPT"])
def test_the_smallest_suns_keep_their_light(integrator: str) -> None:
    """Directions drawn at the rim of their disks are rounded beyond it: they had no density."""
    shots = partial(pictures, lit("SUN", 0.05, sun_angle=1e-6), 8, max_bounces=1)
    assert_equal_means(shots(samples=256), shots(samples=256, integrator=integrator))


def warnings_of(scene: SceneBuilder) -> list[str]:
    return list(engine_core.compile(scene.description, threads=1).warnings)


@pytest.mark.parametrize("kind", ["box", "sphere"])
def test_vertices_that_do_not_resolve_the_shape_are_named(kind: str) -> None:
    """Their places were rounded in silence."""
    assert warnings_of(baked(kind, 1e3)) == []
    name = baked(kind, 1e5).description.meshes[0].name
    for offset in (1e5, 1e6):
        (warning,) = warnings_of(baked(kind, offset))
        assert warning.startswith(f'mesh "{name}": its vertices are')
        assert "its shape is rounded" in warning
    assert warnings_of(moved(1e7)) == [], "only its place is rounded"


def test_what_lies_too_far_from_the_middle_is_named() -> None:
    assert warnings_of(far_corner(1e4)) == []
    (warning,) = warnings_of(far_corner(1e6))
    assert "from the middle of the scene" in warning


def lamp_about_things(soft: bool, radius: float) -> SceneBuilder:
    scene = room()
    lamp("POINT", scene, at=(0.1, -0.3, 0.25), radius=radius, soft_falloff=soft)
    return scene


@pytest.mark.parametrize("integrator", ["LIGHT", "PHOTON", "SPPM"])
def test_what_paths_from_a_hard_lamp_leave_out_is_named(integrator: str) -> None:
    """They leave the sphere outward; what is within it is lit all the same."""

    def notes(scene: SceneBuilder) -> str:
        compiled = engine_core.compile(scene.description, threads=1)
        session = engine_core.Session(compiled, {"integrator": integrator}, ["Combined"])
        return " ".join(session.notes)

    assert "without soft falloff" in notes(lamp_about_things(False, 0.4))
    assert "without soft falloff" not in notes(lamp_about_things(False, 0.1))
    assert "without soft falloff" not in notes(lamp_about_things(True, 0.4))


def test_points_on_tiny_triangles_of_enlarged_instances_are_where_rays_met_them() -> None:
    """They were all taken for a corner: there a picture lost 1 % and photons piled up."""
    names = ("stretched by 1e6 by 1e6 by 1e6", "instances stretched by 1e6 by 1e6 by 1e6")
    found = {case.name: case for case in shapes.cases() if case.name in names}
    plain, instances = (
        picture(found[name].build(), samples=16, **found[name].settings).mean() for name in names
    )
    assert instances == pytest.approx(plain, rel=1e-3)
