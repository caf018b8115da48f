"""What a finished render has to say about itself, for scripts that drive Blender."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .modelled import Modelled


@dataclass(frozen=True)
class RenderRecord:
    """One view layer of one frame. Times are those of `time.perf_counter`, in seconds.

    `progress` is the core's last word: samples, seconds, rays, error. `messages` are all warnings,
    also those that were too many for Blender's own report. `choice` tells why Auto chose the method
    that rendered; empty where the settings named one. `modelled` tells what the scene required.
    """

    layer: str
    progress: Any
    messages: tuple[str, ...]
    threads: int
    choice: str
    modelled: Modelled
    called: float
    described: float
    compiled: float
    first_tile: float
    ended: float


_last: Modelled | None = None

#: Called with the record whenever a final render has ended (a cancelled one too).
listeners: list[Callable[[RenderRecord], None]] = []


def tell(record: RenderRecord) -> None:
    global _last
    _last = record.modelled
    for listener in listeners:
        listener(record)


def last_modelled() -> Modelled | None:
    """Of the last final render of this Blender session; none before one."""
    return _last
