"""Merging with next to nothing, of any size and place, and on what hardly scatters."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from bidirectional_scenes import apart, build, scaled
from scenes import SceneBuilder, background, diffuse, emission, picture, pictures, placed, quad
from statistics_tools import Array, assert_equal_means

SEEDS = 8


def shots(builder: SceneBuilder, **settings: Any) -> Array:
    """Every sample finite: `render` checks it."""
    return pictures(
        builder, SEEDS, **{"integrator": "VCM", "samples": 32, "max_bounces": 4, **settings}
    )


@pytest.mark.parametrize("method", [{}, {"vcm_connections": 0}], ids=["both", "merging"])
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scale(scale: float, method: dict[str, int]) -> None:
    """The radius is of the picture: no unit changes it, and so the blur is the same."""
    here = shots(apart("many", "pinhole"), **method)
    there = shots(scaled(apart("many", "pinhole"), scale), **method)
    assert_equal_means(here, there, block=6)


def test_place() -> None:
    """A million units away, where float32 resolves a sixteenth of one: the scene is large."""
    here = scaled(apart("many", "orthographic"), 4096.0)
    there = scaled(apart("many", "orthographic"), 4096.0, 2.0**20)
    assert_equal_means(shots(here), shots(there), block=6)


@pytest.mark.parametrize("connections", [0, 1])
def test_one_path_from_the_lights(connections: int) -> None:
    """A picture of one pixel, which it covers with its one sample's light."""
    builder = SceneBuilder((1, 1))
    builder.add(quad((-9, -9, 0), (18, 0, 0), (0, 18, 0)), diffuse(0.5))
    builder.description.world = background(1.0)
    builder.camera((0, 0, 5), (0, 0, 0), fov=10)
    settings = {"integrator": "VCM", "vcm_connections": connections, "merge_radius": 1.0}
    many = pictures(builder, 200, samples=16, **settings).mean(axis=(1, 2, 3))
    assert np.isfinite(many).all()
    assert many.mean() == pytest.approx(0.5, abs=5 * many.std() / np.sqrt(len(many)))


def lit(builder: SceneBuilder) -> SceneBuilder:
    builder.add(quad((-1, -1, 0), (2, 0, 0), (0, 2, 0)), diffuse(0.5))
    builder.camera((0, -4, 3), (0, 0, 0))
    return builder


@pytest.mark.parametrize("what", ["no light", "away", "nothing to see", "nothing at all"])
def test_no_path_from_the_lights_meets_anything(what: str) -> None:
    builder = SceneBuilder((8, 8))
    if what == "nothing at all":
        builder.camera((0, 0, 5), (0, 0, 0))
    elif what == "nothing to see":
        lit(builder).camera((0, -4, 3), (0, -8, 6))
        builder.light("POINT", transform=placed(1.0, (0, 0, 2)), emission=(10.0,) * 3)
    else:
        lit(builder)
    if what == "away":
        # It shines up, and the floor is below it.
        builder.light("AREA", transform=placed((1.0, -1.0, -1.0), (0, 0, 2)), emission=(9.0,) * 3)
    image = picture(builder, integrator="VCM", samples=4)
    assert (image == 0).all()


def test_light_leaks_neither_through_a_sheet_nor_round_a_corner() -> None:
    """At a radius as long as the floor is near the wall that the camera sees from behind."""
    builder = SceneBuilder((16, 16))
    builder.add(quad((-2, 0, 0), (4, 0, 0), (0, 0, 2)), diffuse(0.8))
    builder.add(quad((-2, -2, 0), (4, 0, 0), (0, 2, 0)), diffuse(0.8))
    builder.add(quad((-1, -1.5, 1.9), (0, 1, 0), (2, 0, 0)), emission(20.0))
    settings = {"integrator": "VCM", "samples": 32, "vcm_connections": 0, "merge_radius": 8.0}
    builder.camera((0, -3, 1), (0, 0, 1), fov=50)
    assert picture(builder, **settings)[:8].min() > 0.1
    builder.camera((0, 3, 1), (0, 0, 1), fov=50)
    assert (picture(builder, **settings)[:8] == 0).all()


@pytest.mark.parametrize("material", ["near_mirror", "glossy"])
def test_gathering_on_narrow_lobes_does_not_blur(material: str) -> None:
    """What a sharp lobe shows stays where it is."""
    path = pictures(build(material, "mesh"), SEEDS, samples=256, max_bounces=3)
    merged = shots(build(material, "mesh"), samples=64, max_bounces=3, merge_radius=0.25)
    bound = 0.02 * path.mean()
    difference = merged.mean(axis=(0, 1, 2)) - path.mean(axis=(0, 1, 2))
    noise = np.hypot(
        merged.mean(axis=(1, 2)).std(axis=0), path.mean(axis=(1, 2)).std(axis=0)
    ) / np.sqrt(SEEDS)
    assert (abs(difference) < bound + 5 * noise).all()
