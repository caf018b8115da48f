"""Whatever a description says, it is refused in a sentence or drawn: finite, and in time."""

from __future__ import annotations

import copy
import dataclasses
import os
from typing import Any

import numpy as np
import pytest
from descriptions import ANY, scenes
from engine_core.description import SceneDescription
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import engine_core

#: How many times as many examples as in the bounded run.
EFFORT = int(os.environ.get("VERNIER_HOSTILE_EFFORT", "1"))
INTEGRATORS = [
    identifier
    for parameter in engine_core.parameters()
    if parameter.name == "integrator"
    for identifier, *_ in parameter.items
]

usual = settings(
    max_examples=60 * EFFORT,
    deadline=None,
    derandomize=EFFORT == 1,
    database=None,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.generate],
    report_multiple_bugs=False,
)


def draw(description: SceneDescription, **options: Any) -> None:
    """Renders, or is told why not."""
    told = ""
    try:
        scene = engine_core.compile(description, threads=1)
    except (ValueError, TypeError, MemoryError, RuntimeError) as error:
        told = str(error) or "?"
    if told:
        return
    values = {"threads": 1, "samples": 2, "max_bounces": 6, "transparent_bounces": 8, **options}
    session = engine_core.Session(scene, values, ["Combined"])
    session.start()
    assert session.wait(120.0), "the render did not end"
    assert not session.error_message
    picture = session.read("Combined", 0, 0, scene.width, scene.height)
    assert not np.isnan(picture).any()


@usual
@given(scenes(), st.sampled_from(INTEGRATORS))
def test_valid_scenes_are_drawn(description: SceneDescription, integrator: str) -> None:
    engine_core.validate(description)
    draw(description, integrator=integrator)


def holders(value: Any) -> list[Any]:
    """All dataclasses within a description."""
    found = []
    if dataclasses.is_dataclass(value):
        found.append(value)
        for field in dataclasses.fields(value):
            found += holders(getattr(value, field.name))
    elif isinstance(value, list):
        for item in value:
            found += holders(item)
    return found


WRONG = st.one_of(
    ANY,
    st.integers(-(2**70), 2**70),
    st.sampled_from([None, "", "NONSENSE", [], {}, (), (1.0,), (1.0,) * 7, b"bytes", True]),
    st.sampled_from([np.zeros((0, 3), np.float32), np.zeros((2, 2), np.int64),
                     np.full((4, 3), np.nan, np.float32), np.array([5, -3], np.int32)]),
)  # fmt: skip


@usual
@given(scenes(), st.data())
def test_broken_scenes_are_refused_or_drawn(description: SceneDescription, data: Any) -> None:
    """Any field of any part has any value: at the most a sentence comes back."""
    description = copy.deepcopy(description)
    for _ in range(data.draw(st.integers(1, 3))):
        holder = data.draw(st.sampled_from(holders(description)), label="holder")
        if type(holder).__name__ == "Link":
            continue
        field = data.draw(st.sampled_from([f.name for f in dataclasses.fields(holder)]))
        setattr(holder, field, data.draw(WRONG, label=field))
    told = ""
    try:
        engine_core.validate(description)
    except engine_core.DescriptionError as error:
        told = str(error) or "?"
    if told:
        assert "\n" not in told
        return
    film = description.film
    if film.width * film.height > 1 << 16:
        return
    draw(description)


@pytest.mark.parametrize("values", [{"samples": "many"}, {"threads": 2.5}, {"no": 1}, {"seed": -1}])
def test_settings_that_are_none_are_told(values: dict[str, Any]) -> None:
    scene = engine_core.compile(SceneDescription(camera=engine_core.description.Camera()))
    with pytest.raises((ValueError, TypeError)):
        engine_core.Session(scene, values, ["Combined"])
