"""How far a render is: for Blender's header, and in lines that render farms read."""

from __future__ import annotations

import math
import time
from typing import Any

import bpy

from .command_line import is_background_render

# Seconds between two lines of a background render.
_LINE_SECONDS = 1.0


class ProgressLines:
    """Writes lines to standard output in background renders, in the form of Blender's own:

        Fra:1 Mem:120.5M (Peak 131.0M) | Time:00:03.52 | Remaining:00:10.20 | Scene, ViewLayer | …

    Blender 4.5 writes such lines itself; from 5.0 on it does not.
    """

    def __init__(self, scene: bpy.types.Scene, layer: str) -> None:
        self._wanted = is_background_render() and bpy.app.version >= (5, 0, 0)
        self._frame = scene.frame_current
        self._place = f"{scene.name}, {layer}"
        self._start = time.monotonic()
        self._next = self._start

    def show(self, progress: Any) -> None:
        now = time.monotonic()
        if self._wanted and now >= self._next:
            self._next = now + _LINE_SECONDS
            known = math.isfinite(progress.seconds_left)
            self._write(progress, f" | Remaining:{_clock(progress.seconds_left)}" if known else "")

    def end(self, progress: Any) -> None:
        if self._wanted:
            self._write(progress, "")

    def _write(self, progress: Any, left: str) -> None:
        used, peak = memory_megabytes()
        spent = _clock(time.monotonic() - self._start)
        sample = stats_line(progress, time_left=False)
        print(
            f"Fra:{self._frame} Mem:{used:.1f}M (Peak {peak:.1f}M) | Time:{spent}{left}"
            f" | {self._place} | {sample}",
            flush=True,
        )


def _clock(seconds: float) -> str:
    """01:02.50, or 1:01:02.50 from an hour on."""
    minutes, rest = divmod(max(0.0, seconds), 60.0)
    hours, minutes = divmod(int(minutes), 60)
    tail = f"{minutes:02d}:{rest:05.2f}"
    return f"{hours}:{tail}" if hours else tail


def show_progress(engine: bpy.types.RenderEngine, session: Any, with_error: bool) -> Any:
    """The stats line, the progress bar and the memory. The error costs a look at every pixel."""
    progress = session.poll(with_error)
    trying = session.integrator == "AUTO"
    engine.update_stats("", "Choosing the method" if trying else stats_line(progress))
    engine.update_progress(_fraction(progress))
    used, peak = memory_megabytes()
    engine.update_memory_stats(memory_used=used, memory_peak=peak)
    return progress


def _fraction(progress: Any) -> float:
    """How much is done: by samples, or by time where that ends first."""
    by_samples = progress.samples / progress.samples_target if progress.samples_target else 0.0
    total = progress.seconds + progress.seconds_left
    by_time = progress.seconds / total if math.isfinite(total) and total > 0.0 else 0.0
    return min(1.0, max(by_samples, by_time))


def stats_line(progress: Any, time_left: bool = True) -> str:
    """Sample, time left and error of a render in progress."""
    parts = [f"Sample {progress.samples:.0f}/{progress.samples_target:.0f}"]
    if time_left and math.isfinite(progress.seconds_left):
        parts.append(f"Time left {duration(progress.seconds_left)}")
    if progress.ending == "target":
        parts.append("Target reached")
    if math.isfinite(progress.error):
        parts.append(f"Error {100.0 * progress.error:.2g} %")
    return " | ".join(parts)


def duration(seconds: float) -> str:
    """1:02:03, 2:03 or 0:03."""
    whole = round(max(0.0, seconds))
    hours, minutes = divmod(whole // 60, 60)
    tail = f"{minutes:02d}:{whole % 60:02d}" if hours else f"{minutes}:{whole % 60:02d}"
    return f"{hours}:{tail}" if hours else tail


def memory_megabytes() -> tuple[float, float]:
    """Memory of this process now and at its peak; zeros where the system does not say."""
    try:
        with open("/proc/self/status", encoding="ascii") as file:
            rows = dict(line.split(":", 1) for line in file)
        return (_megabytes(rows["VmRSS"]), _megabytes(rows["VmHWM"]))
    except (OSError, KeyError, ValueError):
        return (0.0, 0.0)


def _megabytes(row: str) -> float:
    """Megabytes of a row like "  1234 kB"."""
    return int(row.split()[0]) / 1024.0
