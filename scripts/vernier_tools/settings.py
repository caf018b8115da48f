"""The engine's settings on the command line, from the core's one table of parameters."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from engine_core.tables import Parameter

Value = bool | int | float | str

TRUTHS = {"1": True, "true": True, "on": True, "yes": True}
TRUTHS |= {"0": False, "false": False, "off": False, "no": False}


def table() -> dict[str, Parameter]:
    """All settings by name. Raises ImportError before the core is installed."""
    from engine_core import parameters

    return {parameter.name: parameter for parameter in parameters()}


def most(name: str) -> int:
    """The largest value of a whole-number setting."""
    return int(table()[name].max)


def assignment(text: str) -> tuple[str, Value]:
    """KEY=VALUE as a pair, the value of the setting's type. Raises ArgumentTypeError."""
    name, mark, value = text.partition("=")
    if not mark:
        raise argparse.ArgumentTypeError(f"{text!r} is not KEY=VALUE")
    parameters = table()
    if name not in parameters:
        known = ", ".join(parameters)
        raise argparse.ArgumentTypeError(f"there is no setting {name!r}; there are {known}")
    return name, parsed(parameters[name], value)


class Setting:
    """An argument type: the value of one named setting."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __call__(self, text: str) -> Value:
        parameter = table()[self.name]
        return parsed(parameter, text.removesuffix("%") if parameter.unit == "%" else text)


def parsed(parameter: Parameter, text: str) -> Value:
    """A value of the parameter, checked. Raises ArgumentTypeError that says what is allowed."""
    if parameter.type == "enum":
        known = [identifier for identifier, _, _ in parameter.items]
        if text.upper() not in known:
            names = ", ".join(name.lower() for name in known)
            raise argparse.ArgumentTypeError(f"{parameter.name}: {text!r} is not one of {names}")
        return text.upper()
    if parameter.type == "bool":
        if text.lower() not in TRUTHS:
            raise argparse.ArgumentTypeError(f"{parameter.name}: {text!r} is not true or false")
        return TRUTHS[text.lower()]
    whole = parameter.type == "int"
    try:
        number: int | float = int(text) if whole else float(text)
    except ValueError:
        number = math.nan
    if not parameter.min <= number <= parameter.max:
        kind = "a whole number" if whole else "a number"
        raise argparse.ArgumentTypeError(
            f"{parameter.name}: {text!r} is not {kind} from {parameter.min:g} to {parameter.max:g}"
        )
    return number


def apply(settings: object, values: Mapping[str, object]) -> None:
    """Sets the values on `scene.vernier`."""
    for name, value in values.items():
        setattr(settings, name, value)


def describe() -> str:
    """A list of all settings for the help text."""
    lines = ["settings (for --set):"]
    try:
        parameters = table().values()
    except ImportError:
        return "The settings for --set are listed here once a first call has built the core."
    for parameter in parameters:
        if parameter.type == "enum":
            what = ", ".join(identifier.lower() for identifier, _, _ in parameter.items)
        else:
            what = parameter.type
        default = str(parameter.default).lower()
        lines.append(f"  {parameter.name} ({what}; {default})")
        lines.append(f"      {parameter.description}")
    return "\n".join(lines).replace("%", "%%")
