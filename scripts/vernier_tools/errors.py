"""One way for every command to fail: a clear line and a non-zero exit."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TextIO


class ToolError(Exception):
    """What the user is told, in one line, when a command cannot go on."""


def report(command: str, error: object, stream: TextIO | None = None) -> None:
    """Writes `command: error: …` to `stream` (standard error), line breaks folded into one line."""
    text = " ".join(str(error).split())
    print(f"{command}: error: {text}", file=stream or sys.stderr, flush=True)


def blend_file_there(path: Path) -> None:
    """Raises ToolError where it is not."""
    if not path.is_file():
        raise ToolError(f"{path}: no such file")


def say(command: str, text: str) -> None:
    """What a command is at, on standard error."""
    print(f"{command}: {text}", file=sys.stderr, flush=True)


def ended(command: str, work: Callable[[], int]) -> int:
    """The exit code of a command that does `work`, which returns one or raises."""
    try:
        return work()
    except (ToolError, OSError) as error:
        report(command, error)
        return 1
    except KeyboardInterrupt:
        return 130
