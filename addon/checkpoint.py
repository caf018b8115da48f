"""The saved state of a final render, for renders that are interrupted or go on later."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import bpy
from engine_core.description import SceneDescription

from engine_core import storage

#: Seconds between two states of a render.
INTERVAL = 60.0
#: Share of the time that saving may take where states are large.
SAVING_SHARE = 0.02

_active: Checkpoint | None = None


class Checkpoint:
    """The file where one render keeps its state. `path` is "" where none was asked for."""

    def __init__(
        self, scene: bpy.types.Scene, description: SceneDescription, is_preview: bool
    ) -> None:
        settings = scene.vernier
        name: str = "" if is_preview else settings.checkpoint
        self.path = bpy.path.abspath(name) if name else ""
        self.digest = storage.digest(description) if self.path else ""
        self.resume = self.path if settings.resume and Path(self.path).is_file() else ""
        self._session: Any = None
        self._next = 0.0

    def begin(self, session: Any) -> None:
        global _active
        self._session = session
        self._next = time.monotonic() + INTERVAL
        _active = self if self.path else None

    def save_when_due(self) -> None:
        """Saves the state where the last one is old enough. Raises RuntimeError."""
        if self.path and time.monotonic() >= self._next:
            self.save()

    def save(self) -> None:
        """Saves the state, if one was asked for. Raises RuntimeError, with the file untouched."""
        if not self.path:
            return
        start = time.monotonic()
        self._session.save(self.path, self.digest)
        end = time.monotonic()
        self._next = end + max(INTERVAL, (end - start) / SAVING_SHARE)

    def end(self) -> None:
        """The last state, whatever ended the render."""
        global _active
        _active = None
        self.save()


def save_active() -> None:
    """Saves the state of the render that is under way, for a process that is about to end."""
    if _active is not None:
        _active.save()
