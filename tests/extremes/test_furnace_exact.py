"""Closed rooms without noise: paths that find light by chance alone all carry the same."""

from __future__ import annotations

import numpy as np
import pytest
from extreme_cases.furnaces import after, furnace, unlimited
from extreme_cases.place import baked
from scenes import picture


@pytest.mark.parametrize("bounces", [0, 1, 100, 1000, 10_000])
@pytest.mark.parametrize("albedo", [0.9, 0.999, 1.0])
def test_a_room_s_radiance_after_many_bounces(albedo: float, bounces: int) -> None:
    """Without roulette a path brings emission * albedo^k at each surface, whichever it meets.

    A path that leaks, or is lost at an edge, would be missed; float32 keeps the sum to some of its
    last places for each bounce that counts.
    """
    emitted = 1.0 - albedo if albedo < 1.0 else 1.0 / (bounces + 2)
    counted = min(bounces + 2, 20 / (1.0 - albedo) if albedo < 1.0 else bounces + 2)
    image = picture(
        furnace(albedo, emitted, size=4), samples=4, direct_light="BSDF", **unlimited(bounces)
    )
    truth = after(bounces, albedo, emitted)
    rounding = counted * float(np.finfo(np.float32).eps)
    np.testing.assert_allclose(image, truth, rtol=1e-6 + rounding)


@pytest.mark.parametrize("offset", [0.0, 1e4, 1e5, 1e6])
@pytest.mark.parametrize("kind", ["box", "sphere"])
def test_a_room_far_from_its_origin_keeps_its_light(kind: str, offset: float) -> None:
    """Baked up to a million times its size away: no path of 100 bounces finds a way out."""
    scene = baked(kind, offset)
    image = picture(scene, samples=128, direct_light="BSDF", **unlimited(100))
    truth = after(100, 0.9, 0.1)
    np.testing.assert_allclose(image, truth, rtol=1e-5)
