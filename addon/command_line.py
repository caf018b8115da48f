"""Settings given to Blender's command line after `--`, and the exit code of background renders.

    blender --background scene.blend --engine VERNIER -f 1 -- --vernier-time 60 --vernier-samples=64

Every setting of the engine is an option: its identifier with `--vernier-` before it and hyphens for
underscores. The options win over the file's settings and are not saved with it.
"""

from __future__ import annotations

import atexit
import os
import sys
from collections.abc import Sequence
from typing import Any

import bpy

PREFIX = "--vernier-"
# Short names of settings.
ALIASES = {"time": "time_limit"}
# Blender's own options that render without a script.
_RENDER_OPTIONS = {"-f", "-a", "--render-frame", "--render-anim"}

Value = bool | int | float | str

_failures = 0
_watching = False


class OptionError(ValueError):
    """An option cannot be used; the message says which and why."""


def overrides(
    parameters: Sequence[Any], arguments: Sequence[str] | None = None
) -> dict[str, Value]:
    """The settings that the command line gives, by name. Raises OptionError.

    `parameters` is the core's table; `arguments` is the whole command line (this process' own).
    Words after `--` that are not ours belong to other add-ons and are passed over.
    """
    words = list(sys.argv if arguments is None else arguments)
    words = words[words.index("--") + 1 :] if "--" in words else []
    known = {parameter.name: parameter for parameter in parameters}
    values: dict[str, Value] = {}
    while words:
        word = words.pop(0)
        if not word.startswith(PREFIX):
            continue
        option, mark, text = word.partition("=")
        if not mark:
            if not words:
                raise OptionError(f"{option}: a value is missing")
            text = words.pop(0)
        name = option.removeprefix(PREFIX).replace("-", "_")
        name = ALIASES.get(name, name)
        if name not in known:
            names = ", ".join(PREFIX + name.replace("_", "-") for name in known)
            raise OptionError(f"there is no option {option}; there are {names}")
        values[name] = _parsed(known[name], option, text)
    return values


def _parsed(parameter: Any, option: str, text: str) -> Value:
    if parameter.type == "enum":
        items = [identifier for identifier, _, _ in parameter.items]
        if text.upper() not in items:
            raise OptionError(f"{option}: {text!r} is not one of {', '.join(items).lower()}")
        return text.upper()
    try:
        number = int(text) if parameter.type == "int" else float(text.removesuffix("%"))
    except ValueError:
        number = None
    if number is None or not parameter.min <= number <= parameter.max:
        kind = "a whole number" if parameter.type == "int" else "a number"
        low, high = f"{parameter.min:g}", f"{parameter.max:g}"
        raise OptionError(f"{option}: {text!r} is not {kind} from {low} to {high}")
    return number


def is_background_render() -> bool:
    """Whether Blender was started to render and to end, by options rather than by a script."""
    words = sys.argv[: sys.argv.index("--")] if "--" in sys.argv else sys.argv
    return bool(bpy.app.background and _RENDER_OPTIONS.intersection(words))


def render_failed() -> None:
    """Notes a failed render: Blender itself would end with exit code 0.

    Its last steps cannot be told otherwise, so the process ends in the interpreter's: all pictures
    are written by then.
    """
    global _failures, _watching
    _failures += 1
    if is_background_render() and not _watching:
        _watching = True
        atexit.register(_end_with_failure)


def _end_with_failure() -> None:
    print(f"Vernier: {_failures} of the renders failed", file=sys.stderr)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(1)
