"""One way for every command to fail: a clear line and a non-zero exit."""

from __future__ import annotations

import sys
from typing import TextIO


class ToolError(Exception):
    """What the user is told, in one line, when a command cannot go on."""


def report(command: str, error: object, stream: TextIO | None = None) -> None:
    """Writes `command: error: …` to `stream` (standard error), line breaks folded into one line."""
    text = " ".join(str(error).split())
    print(f"{command}: error: {text}", file=stream or sys.stderr, flush=True)
