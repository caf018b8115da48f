"""Every pass against the same pass of Cycles."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("bpy")

from agreement import assert_agreement
from cycles_pairs import run

LIGHT = [f"{g} {p}" for g in ("Diffuse", "Glossy", "Transmission") for p in ("Direct", "Indirect")]
COLOR = ["Diffuse Color", "Glossy Color", "Transmission Color"]
# Added before the comparison, because components have either sign.
VECTORS = {"Position": 5.0, "Normal": 1.5, "UV": 0.5}


@pytest.fixture(scope="module")
def passes(tmp_path_factory: Any) -> dict[str, Any]:
    return run("pass_pairs.py", tmp_path_factory.mktemp("passes") / "passes.npz")


@pytest.mark.parametrize("name", ["Combined", "Emission", "Environment", *COLOR])
def test_pass(passes: dict[str, Any], name: str) -> None:
    assert_agreement(passes[f"{name} CYCLES"], passes[f"{name} VERNIER"])


@pytest.mark.parametrize("name", LIGHT)
def test_light_pass(passes: dict[str, Any], name: str) -> None:
    """These are quotients and noisy where little of the group is seen: power is less."""
    assert_agreement(passes[f"{name} CYCLES"], passes[f"{name} VERNIER"], power=0.04)


@pytest.mark.parametrize("name", VECTORS)
def test_vector_pass(passes: dict[str, Any], name: str) -> None:
    shift = VECTORS[name]
    assert_agreement(passes[f"{name} CYCLES"] + shift, passes[f"{name} VERNIER"] + shift)


def test_depth(passes: dict[str, Any]) -> None:
    """Metres along the view axis, and 1e10 where nothing is."""
    depths = [passes[f"Depth {engine}"] for engine in ("CYCLES", "VERNIER")]
    for depth in depths:
        assert depth.max() == np.float32(1e10)
        assert depth.min() > 4.0
    assert_agreement(*(np.minimum(depth, 20.0) for depth in depths))


def test_passes_sum_to_the_picture(passes: dict[str, Any]) -> None:
    """Colour times light over the groups, emission and environment make Combined."""
    of = {name.removesuffix(" VERNIER"): a for name, a in passes.items() if "VERNIER" in name}
    total = of["Emission"] + of["Environment"]
    for group in ("Diffuse", "Glossy", "Transmission"):
        light = of[f"{group} Direct"] + of[f"{group} Indirect"]
        total = total + light * of[f"{group} Color"]
    np.testing.assert_allclose(total, of["Combined"][..., :3], rtol=2e-3, atol=2e-3)
