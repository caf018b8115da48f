"""Each technique alone, unweighted, makes the picture of the paths of its length.

The reference is the difference of two path-traced pictures that differ in one bounce.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest
from bidirectional_scenes import apart
from scenes import pictures
from statistics_tools import Array, assert_equal_means

SEEDS = 8
SHORTEST, LONGEST = 3, 4
#: Scenes whose paths of up to six vertices are tested.
LONG = {"area": 6, "world": 5, "rough_glass": 5}

#: Scene names, and the least number of vertices from the light: delta lights are not met by chance.
SCENES: dict[str, tuple[dict[str, str], int]] = {
    "area": ({"light": "area", "view": "pinhole"}, 0),
    "ellipse": ({"light": "area_ellipse", "view": "focus_blades"}, 0),
    "spread": ({"light": "area_spread", "view": "pinhole"}, 0),
    "parallel": ({"light": "area_parallel", "view": "focus"}, 1),
    "point": ({"light": "point", "view": "pinhole"}, 1),
    "point_soft": ({"light": "point_soft", "view": "pinhole"}, 0),
    "point_hard": ({"light": "point_hard", "view": "orthographic"}, 0),
    "spot": ({"light": "spot", "view": "orthographic_focus"}, 1),
    "spot_hard": ({"light": "spot_hard", "view": "pinhole"}, 0),
    "spot_soft": ({"light": "spot_soft", "view": "pinhole"}, 0),
    "sun": ({"light": "sun", "view": "crop"}, 1),
    "sun_disk": ({"light": "sun_disk", "view": "pinhole"}, 0),
    "world": ({"light": "world", "view": "orthographic_focus"}, 0),
    "sky": ({"light": "sky", "view": "pinhole"}, 0),
    "mesh": ({"light": "mesh", "view": "clipped"}, 0),
    "mesh_textured": ({"light": "mesh_textured", "view": "pinhole"}, 0),
    "mesh_one_sided": ({"light": "mesh_one_sided", "view": "pinhole"}, 0),
    "lamp_textured": ({"light": "lamp_textured", "view": "pinhole"}, 0),
    "no_mis": ({"light": "no_mis", "view": "pinhole"}, 1),
    "in_a_lamp": ({"light": "mesh", "view": "in_a_lamp"}, 0),
    "translucent": ({"light": "area", "view": "pinhole", "material": "diffuse_and_translucent"}, 0),
    "rough_glass": ({"light": "area", "view": "pinhole", "material": "rough_glass"}, 0),
    "bump": ({"light": "area", "view": "pinhole", "material": "bump_diffuse"}, 0),
    "facing": ({"light": "sun_disk", "view": "pinhole", "material": "facing"}, 0),
    "backfacing": ({"light": "area", "view": "pinhole", "material": "backfacing"}, 0),
    "half_clear": ({"light": "area", "view": "pinhole", "material": "half_clear"}, 0),
    "facing_clear": ({"light": "mesh", "view": "pinhole", "material": "facing_clear"}, 0),
    "coat": ({"light": "area", "view": "pinhole", "material": "principled_coat"}, 0),
}


def shots(name: str, **settings: Any) -> Array:
    return pictures(apart(**SCENES[name][0]), SEEDS, samples=32, roulette_threshold=0.0, **settings)


@cache
def up_to(name: str, vertices: int) -> Array:
    """What paths of at most so many vertices carry, the lens and the light's among them."""
    if vertices == 2:
        seen = {"only_light_vertices": 0, "only_camera_vertices": 2}
        return shots(name, integrator="BDPT", **seen)
    return shots(name, max_bounces=vertices - 3)


@pytest.mark.parametrize("name", SCENES)
def test_each_technique_alone(name: str) -> None:
    for count in range(SHORTEST, LONG.get(name, LONGEST) + 1):
        reference = up_to(name, count) - up_to(name, count - 1)[::-1]
        for s in range(SCENES[name][1], count):
            alone = shots(
                name,
                integrator="BDPT",
                only_light_vertices=s,
                only_camera_vertices=count - s,
                unweighted=1,
                max_bounces=count - 3,
            )
            # Lights that walks meet by chance are rare: only the picture's mean is near normal.
            try:
                assert_equal_means(reference, alone, block=12 if s == 0 else 6)
            except AssertionError as error:
                raise AssertionError(f"technique ({s}, {count - s}): {error}") from error
