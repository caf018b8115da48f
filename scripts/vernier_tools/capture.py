"""Keeps what Blender prints off the terminal, and keeps it for messages."""

from __future__ import annotations

import os
import sys
import tempfile
from contextlib import suppress
from typing import TextIO

from vernier_tools.errors import report


class Capture:
    """From its making on, standard output and error of this process go to a temporary file.

    Blender and the libraries in it write to the file descriptors themselves, so these are what is
    redirected. `terminal` and `terminal_error` still write to where the two led before.
    """

    def __init__(self) -> None:
        sys.stdout.flush()
        sys.stderr.flush()
        self.terminal: TextIO = os.fdopen(os.dup(1), "w")
        self.terminal_error: TextIO = os.fdopen(os.dup(2), "w")
        self._log = tempfile.TemporaryFile()  # noqa: SIM115 (open until the process ends)
        os.dup2(self._log.fileno(), 1)
        os.dup2(self._log.fileno(), 2)

    def text(self) -> str:
        """All that was printed so far."""
        sys.stdout.flush()
        sys.stderr.flush()
        size = os.fstat(self._log.fileno()).st_size
        return os.pread(self._log.fileno(), size, 0).decode(errors="replace")

    def messages(self, kind: str) -> list[str]:
        """What Blender reported as `kind` ("Error" or "Warning"), each once, in order."""
        mark = kind + ": "
        lines = (line.strip() for line in self.text().splitlines())
        found = (line.split(mark, 1)[1] for line in lines if line.startswith(mark))
        return list(dict.fromkeys(found))

    def report(self, command: str, error: object) -> None:
        """Tells the user of an error, on the terminal."""
        report(command, error, self.terminal_error)

    def flush(self) -> None:
        """Makes sure that all written is on its way; a reader that has gone is no error."""
        for stream in (self.terminal, self.terminal_error):
            with suppress(BrokenPipeError):
                stream.flush()
