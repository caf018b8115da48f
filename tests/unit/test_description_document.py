"""The written specification of the scene description names every field, with its default."""

from __future__ import annotations

import dataclasses
import re
from enum import Enum
from pathlib import Path

import engine_core.description
import pytest

from engine_core import storage

DOCUMENT = Path(__file__).parents[2] / "docs" / "scene_description.md"
KINDS = {
    name: kind
    for name, kind in vars(engine_core.description).items()
    if dataclasses.is_dataclass(kind) and isinstance(kind, type)
}


def rows(name: str) -> dict[str, list[str]]:
    """The cells of the table in a dataclass's section, by field."""
    parts = re.split(r"^## ", DOCUMENT.read_text(encoding="utf-8"), flags=re.MULTILINE)
    section = next(part for part in parts if part.startswith(f"{name}\n"))
    lines = [line for line in section.splitlines() if line.startswith("| `")]
    table = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {cells[0].strip("`"): cells[1:] for cells in table}


@pytest.mark.parametrize("name", KINDS)
def test_every_field_has_a_row_and_every_row_a_field(name: str) -> None:
    assert list(rows(name)) == [field.name for field in dataclasses.fields(KINDS[name])]


@pytest.mark.parametrize("name", KINDS)
def test_plain_defaults_are_as_written(name: str) -> None:
    table = rows(name)
    for field in dataclasses.fields(KINDS[name]):
        default = field.default
        if default is dataclasses.MISSING:
            continue
        if isinstance(default, Enum):
            shown = default.name if field.name == "normal_domain" else str(int(default))  # type: ignore[call-overload]
        else:
            shown = repr(default)
        assert table[field.name][1] == f"`{shown}`", field.name


def test_the_saved_form_is_named_as_it_is() -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    assert f'"format": "{storage.FORMAT}", "version": {storage.VERSION}' in text
