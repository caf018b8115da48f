"""Vertex connection and merging makes the path tracer's pictures, but for the blur of its radius.

Where light falls evenly there is nothing to blur, and the pictures agree at any radius. Elsewhere
the bias is bounded: a merge takes the light about a point for that which falls on it, and what lies
beyond an edge for dark.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from bidirectional_scenes import MATERIALS, SUN, build, look_at
from scenes import SceneBuilder, background, diffuse, picture, pictures, quad
from statistics_tools import Array, assert_equal_means, block_means

SEEDS = 6
SAMPLES = 48
#: What merges find alone, and beside the techniques that join.
METHODS = {"merging": {"vcm_connections": 0}, "both": {}}
#: Of the bluntest kinds of scattering down to narrow lobes, of both sides of a surface, and such as
#: only one of the two sub-paths may meet.
EVEN = [
    "diffuse",
    "oren_nayar",
    "glossy",
    "near_mirror",
    "rough_glass",
    "bump_diffuse",
    "sheen",
    "principled_coat",
    "principled_alpha",
    "diffuse_and_mirror",
    "diffuse_and_translucent",
    "fresnel",
    "facing",
    "backfacing_glass",
    "light_path_diffuse",
]


def between_sheets(material: str) -> SceneBuilder:
    """A floor under a half clear ceiling, both endless: on either the light is even."""
    scene = SceneBuilder((12, 12))
    scene.add(quad((-20, -20, 0), (40, 0, 0), (0, 40, 0)), MATERIALS[material])
    scene.add(quad((-20, -20, 2), (40, 0, 0), (0, 40, 0)), MATERIALS["half_clear"])
    toward = look_at((0.8, -0.9, 2.2), (0, 0.2, 0.4))
    scene.light("SUN", transform=toward, emission=SUN, sun_angle=0.5)
    scene.description.world = background(0.8, (0.5, 0.7, 1.0))
    scene.camera((0, -1.2, 0.9), (0, 0, 0), fov=20)
    return scene


@cache
def even_reference(material: str) -> Array:
    return pictures(between_sheets(material), SEEDS, samples=SAMPLES, max_bounces=3)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("material", EVEN)
def test_even_light_is_not_blurred(material: str, method: str) -> None:
    """At a radius that spans a sixth of the picture."""
    merged = pictures(
        between_sheets(material),
        SEEDS,
        integrator="VCM",
        samples=SAMPLES,
        max_bounces=3,
        merge_radius=4.0,
        merge_alpha=1.0,
        **METHODS[method],
    )
    assert_equal_means(even_reference(material), merged, block=6)


@pytest.mark.parametrize("method", METHODS)
def test_limits_on_kinds_of_bounces(method: str) -> None:
    limits = {"samples": SAMPLES, "max_bounces": 3, "diffuse_bounces": 0, "transmission_bounces": 0}
    scene = between_sheets("principled_coat")
    merged = pictures(
        scene, SEEDS, integrator="VCM", merge_radius=4.0, merge_alpha=1.0, **limits,
        **METHODS[method],
    )  # fmt: skip
    limited = pictures(scene, SEEDS, **limits)
    assert limited.mean() < 0.99 * even_reference("principled_coat").mean()
    assert_equal_means(limited, merged, block=6)


def test_without_merging_it_is_bidirectional_path_tracing() -> None:
    """To the last bit, on one thread: splats of several are summed in any order."""
    scene = build("principled", "many")
    settings = {"samples": 8, "threads": 1}
    joined = picture(scene, integrator="BDPT", **settings)
    for off in ({"vcm_merging": 0}, {"merge_radius": 0.0}):
        np.testing.assert_array_equal(picture(scene, integrator="VCM", **off, **settings), joined)


def test_threads_leave_the_picture() -> None:
    scene = build("rough_glass", "many")
    settings = {"integrator": "VCM", "samples": 4}
    one, three = (picture(scene, threads=threads, **settings) for threads in (1, 3))
    np.testing.assert_allclose(three, one, rtol=1e-6, atol=1e-9)


#: Edges, corners and a coarse ball; a hard-edged spot; light through narrow glass.
UNEVEN = {"principled": "area", "diffuse": "spot", "rough_glass": "many"}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("material", UNEVEN)
def test_blur_is_bounded_by_what_half_of_the_radius_changes(material: str, method: str) -> None:
    """What falls beside an edge is lost in proportion to the radius, all else to its square: so
    the bias is no more than twice what half of the radius makes of it."""
    scene = build(material, UNEVEN[material])
    shots = {
        radius: pictures(
            scene,
            SEEDS,
            integrator="VCM",
            samples=64,
            max_bounces=4,
            merge_radius=radius,
            merge_alpha=1.0,
            **METHODS[method],
        )
        for radius in (1.0, 0.5)
    }
    path = pictures(scene, SEEDS, samples=128, max_bounces=4)
    wide, narrow, truth = (block_means(p, 6) for p in (shots[1.0], shots[0.5], path))
    noise = [x.std(axis=0, ddof=1) / np.sqrt(SEEDS) for x in (wide, narrow, truth)]
    bias = abs(wide.mean(axis=0) - truth.mean(axis=0))
    bound = 2 * abs(wide.mean(axis=0) - narrow.mean(axis=0))
    sigma = np.sqrt(9 * noise[0] ** 2 + 4 * noise[1] ** 2 + noise[2] ** 2)
    assert (bias <= bound + 5 * sigma).all()
    # And small in all, at twice the radius of this picture's pixels.
    assert bias.sum() < (0.12 if method == "merging" else 0.04) * truth.mean(axis=0).sum()


@pytest.mark.parametrize("alpha", [0.5, 0.75, 1.0])
def test_noise_falls_at_the_published_rate(alpha: float) -> None:
    """A sample's variance goes with the inverse of its disk's area, that of n together with n to
    the power of -alpha (Kaplanyan and Dachsbacher 2013, section 4)."""
    scene = SceneBuilder((12, 12))
    scene.add(quad((-20, -20, 0), (40, 0, 0), (0, 40, 0)), diffuse(0.5))
    scene.light("SUN", transform=look_at((1, -1, 3), (0, 0, 0)), emission=SUN, sun_angle=0.0)
    scene.camera((0, -1.2, 0.9), (0, 0, 0), fov=20)
    # Of a sun that is a point, merges alone know, and with few paths in each disk these are as
    # independent as chance: more would be spread better than that.
    settings = {"integrator": "VCM", "merge_radius": 0.5, "merge_alpha": alpha,
                "vcm_connections": 0}  # fmt: skip
    counts = (8, 32, 128)
    variances = [
        pictures(scene, 12, samples=samples, **settings).var(axis=0, ddof=1).mean()
        for samples in counts
    ]
    slope = np.polyfit(np.log(counts), np.log(variances), 1)[0]
    assert slope == pytest.approx(-alpha, abs=0.12)
