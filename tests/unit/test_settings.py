"""The table of settings is consistent, and refuses what it does not know in one sentence."""

from __future__ import annotations

from typing import Any

import pytest
from engine_core.description import Film
from scenes import SceneBuilder

import engine_core
from engine_core import Parameter

ALL_ROWS = engine_core.parameters()
ROWS = [row for row in ALL_ROWS if not row.of_film]
FILM_ROWS = [row for row in ALL_ROWS if row.of_film]
NUMBERS = [row for row in ROWS if row.type != "enum"]
ENUMS = [row for row in ROWS if row.type == "enum"]
ALL_NUMBERS = [row for row in ALL_ROWS if row.type != "enum"]
ALL_ENUMS = [row for row in ALL_ROWS if row.type == "enum"]


@pytest.fixture(scope="module")
def scene() -> Any:
    return engine_core.compile(SceneBuilder((1, 1)).description, threads=1)


def names(rows: list[Parameter]) -> list[str]:
    return [row.name for row in rows]


def accept(scene: Any, **settings: Any) -> None:
    engine_core.Session(scene, settings, ["Combined"])


def refuse(scene: Any, **settings: Any) -> str:
    """The one sentence that refuses the settings."""
    with pytest.raises((ValueError, TypeError)) as caught:
        engine_core.Session(scene, settings, ["Combined"])
    text = str(caught.value)
    assert text
    assert "\n" not in text
    return text


def test_names_are_unique_identifiers() -> None:
    assert len(set(names(ALL_ROWS))) == len(ALL_ROWS) > 0
    assert all(row.name.isidentifier() and row.name.islower() for row in ALL_ROWS)


@pytest.mark.parametrize("row", ALL_ROWS, ids=names(ALL_ROWS))
def test_every_row_is_told_to_the_user(row: Parameter) -> None:
    assert row.label
    assert row.group
    assert row.description
    assert not row.description.endswith(".")  # Blender adds the full stop


@pytest.mark.parametrize("row", ALL_NUMBERS, ids=names(ALL_NUMBERS))
def test_a_number_s_default_and_slider_lie_within_its_range(row: Parameter) -> None:
    assert isinstance(row.default, int if row.type == "int" else float)
    assert row.min <= row.soft_min < row.soft_max <= row.max
    assert row.min <= row.default <= row.max
    assert row.items == ()


@pytest.mark.parametrize("row", ALL_ENUMS, ids=names(ALL_ENUMS))
def test_a_choice_s_items_are_named_and_told(row: Parameter) -> None:
    identifiers = [item[0] for item in row.items]
    assert row.default in identifiers
    assert len(set(identifiers)) == len(identifiers) > 1
    assert all(label and description for _, label, description in row.items)


@pytest.mark.parametrize("row", ROWS, ids=names(ROWS))
def test_defaults_and_limits_are_accepted(scene: Any, row: Parameter) -> None:
    values = [item[0] for item in row.items] if row.items else [row.default, row.min, row.max]
    for value in values:
        number = int(value) if row.type == "int" else value
        if row.name != "threads" or number <= 8:
            accept(scene, **{row.name: number})


@pytest.mark.parametrize("row", NUMBERS, ids=names(NUMBERS))
def test_numbers_out_of_range_are_refused(scene: Any, row: Parameter) -> None:
    values: list[Any] = [row.min - 1, row.max + 1, -1e300, 1e300]
    values += [float("nan"), float("inf"), -float("inf")]
    if row.type == "int":
        values += [int(row.min) - 1, int(row.max) + 1, 2**62, -(2**62), 2**70, row.default + 0.5]
    for value in values:
        text = refuse(scene, **{row.name: value})
        assert f"setting {row.name}: " in text
        assert "is outside" in text or "is not a whole number" in text


@pytest.mark.parametrize("row", NUMBERS, ids=names(NUMBERS))
def test_text_is_no_number(scene: Any, row: Parameter) -> None:
    assert refuse(scene, **{row.name: "many"}) == f"setting {row.name}: 'many' is not a number"


@pytest.mark.parametrize("row", [r for r in NUMBERS if r.type == "int"], ids=lambda r: r.name)
def test_whole_floats_are_whole_numbers(scene: Any, row: Parameter) -> None:
    accept(scene, **{row.name: float(row.default)})


@pytest.mark.parametrize("row", ENUMS, ids=names(ENUMS))
def test_choices_are_made_by_identifier(scene: Any, row: Parameter) -> None:
    known = ", ".join(item[0] for item in row.items)
    for bad in ("", "NONE_SUCH", str(row.default).lower()):
        text = refuse(scene, **{row.name: bad})
        assert text == f"setting {row.name}: '{bad}' is not one of {known}"
    assert "not a number" in refuse(scene, **{row.name: 0})


def test_the_film_has_one_master(scene: Any) -> None:
    """What the description's film decides is no setting of a session; the defaults are its own."""
    film = Film()
    assert {row.name: row.default for row in FILM_ROWS} == {
        "pixel_filter": film.filter,
        "filter_width": film.filter_width,
        "film_exposure": film.exposure,
    }
    for row in FILM_ROWS:
        assert "the scene description has it" in refuse(scene, **{row.name: row.default})


def test_unknown_settings_are_named(scene: Any) -> None:
    assert refuse(scene, sampels=5) == "there is no setting named sampels"


@pytest.mark.parametrize("value", [None, [1], {}, b"1", object()])
def test_values_of_other_types_are_refused(scene: Any, value: Any) -> None:
    with pytest.raises(TypeError):
        engine_core.Session(scene, {"samples": value}, ["Combined"])


def test_settings_reach_the_render(scene: Any) -> None:
    session = engine_core.Session(scene, {"samples": 77, "threads": 3}, ["Combined"])
    assert session.poll().samples_target == 77
    assert session.threads == 3
    assert engine_core.Session(scene, {}, ["Combined"]).threads >= 1
