"""The tables that the core declares: settings, passes and shader nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Parameter:
    """A setting. Its identifier in Blender is `name`, on the command line `--set name=value`.

    Those `of_film` are members of the description's `Film`; a session does not take them.
    """

    name: str
    group: str
    type: str  # int, float, enum
    default: int | float | str
    min: float
    max: float
    soft_min: float
    soft_max: float
    items: tuple[tuple[str, str, str], ...]  # enum: identifier, label, description
    label: str
    description: str
    unit: str
    of_film: bool


@dataclass(frozen=True)
class PassInfo:
    """A render pass. `channels` has one letter a channel; `type` is COLOR, VECTOR or VALUE."""

    name: str
    legacy_name: str  # in Blender 4.5
    channels: str
    type: str


def parameters_from(rows: list[dict[str, Any]]) -> list[Parameter]:
    return [
        Parameter(
            name=row["name"],
            group=row["group"],
            type=row["type"],
            default=row["default"],
            min=row["minimum"],
            max=row["maximum"],
            soft_min=row["soft_minimum"],
            soft_max=row["soft_maximum"],
            items=row["items"],
            label=row["label"],
            description=row["description"],
            unit=row["unit"],
            of_film=row["of_film"],
        )
        for row in rows
    ]


def passes_from(rows: list[dict[str, Any]]) -> list[PassInfo]:
    return [PassInfo(**row) for row in rows]
