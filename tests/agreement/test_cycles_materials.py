"""Every closure and every input of Principled against Cycles, on spheres under many lights.

Rough glass is compared by sampling the BSDF alone, because Cycles' light samples also count
directions that no facet refracts into each other (docs/differences_from_cycles.md).
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("bpy")

from agreement import assert_agreement
from cycles_pairs import run
from material_cases import BSDF_SAMPLED, CASES

# Blender 4.5 has no thin films on metal; Vernier has those of 5.2 in both.
OLD = version("bpy").startswith("4.")
NEW_IN_5 = {"principled_film_metal"}

SHEETS = {"surfaces": [n for n in CASES if n not in BSDF_SAMPLED], "glass": sorted(BSDF_SAMPLED)}


@pytest.fixture(scope="module")
def sheet(tmp_path_factory: Any) -> Callable[[str], dict[str, Any]]:
    """The sheets' tiles, rendered when first asked for."""
    folder: Path = tmp_path_factory.mktemp("sheets")
    done: dict[str, dict[str, Any]] = {}

    def get(name: str) -> dict[str, Any]:
        if name not in done:
            done[name] = run("material_sheet.py", folder / f"{name}.npz", name, *SHEETS[name])
        return done[name]

    return get


@pytest.mark.parametrize(
    ("name", "material"), [(sheet, name) for sheet, names in SHEETS.items() for name in names]
)
def test_material(sheet: Any, name: str, material: str) -> None:
    if OLD and material in NEW_IN_5:
        pytest.skip("Blender 5 renders this material otherwise than 4.5")
    number = SHEETS[name].index(material)
    tiles = sheet(name)
    assert_agreement(tiles["CYCLES"][number], tiles["VERNIER"][number], block=4)


def test_materials_differ(sheet: Any) -> None:
    """The tiles are not one and the same: the comparison sees the materials."""
    means = np.array([t.mean() for t in sheet("surfaces")["CYCLES"]])
    assert len(np.unique(means.round(4))) > 0.8 * len(means)
