"""A progress line: refreshed in place on a terminal, plain lines now and then elsewhere."""

from __future__ import annotations

import os
import time
from typing import TextIO

PLAIN_INTERVAL = 10.0  # seconds between two plain lines
TTY_INTERVAL = 0.1


class ProgressLine:
    """Writes the latest status to `stream`, at most as often as is of use there."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self.tty = stream.isatty()
        self.interval = TTY_INTERVAL if self.tty else PLAIN_INTERVAL
        self.last_time = -self.interval
        self.width = 0

    def show(self, text: str) -> None:
        now = time.monotonic()
        if now - self.last_time < self.interval:
            return
        self.last_time = now
        if not self.tty:
            self._write(text + "\n")
            return
        try:
            columns = os.get_terminal_size(self.stream.fileno()).columns
        except OSError:
            columns = 80
        text = text[: columns - 1]
        # A carriage return and blanks work on every terminal; escape sequences do not.
        self._write("\r" + text.ljust(self.width))
        self.width = len(text)

    def clear(self) -> None:
        """Wipes the line, so that ordinary output can follow."""
        if self.tty and self.width:
            self._write("\r" + " " * self.width + "\r")
            self.width = 0

    def _write(self, text: str) -> None:
        # A closed pipe must not end a render whose picture is still to be saved.
        try:
            self.stream.write(text)
            self.stream.flush()
        except (BrokenPipeError, ValueError):
            self.interval = float("inf")
