"""Every kind of light, visibility, camera and film setting against Cycles.

A representative part runs always; `-m thorough` selects the rest.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("bpy")

from agreement import assert_agreement
from cycles_pairs import run
from light_cases import CAMERAS, LIGHTS, QUICK


def _cases(names: Any) -> list[Any]:
    thorough = pytest.mark.thorough
    return [n if n in QUICK else pytest.param(n, marks=thorough) for n in names]


@pytest.fixture(scope="module")
def pictures(request: pytest.FixtureRequest, tmp_path_factory: Any) -> dict[str, Any]:
    """The pictures of all cases that this run has selected, made in one process."""
    selected = [
        item.callspec.params["name"]
        for item in request.session.items
        if item.path == request.path and hasattr(item, "callspec")
    ]
    folder: Path = tmp_path_factory.mktemp("lights")
    return run("light_pairs.py", folder / "pictures.npz", *dict.fromkeys(selected))


@pytest.mark.parametrize("name", _cases(LIGHTS))
def test_light(pictures: dict[str, Any], name: str) -> None:
    assert_agreement(pictures[f"{name} CYCLES"], pictures[f"{name} VERNIER"])


@pytest.mark.parametrize("name", _cases(CAMERAS))
def test_camera(pictures: dict[str, Any], name: str) -> None:
    assert_agreement(pictures[f"{name} CYCLES"], pictures[f"{name} VERNIER"])
