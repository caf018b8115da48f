"""What a render did, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from vernier_tools.measure import status_bytes

if TYPE_CHECKING:
    from addon.record import RenderRecord

# What Blender puts before an engine's own words, in 4.5 ("Fra:1 Mem:9M (Peak 9M)") and in 5.
BLENDER_PREFIXES = ("Fra:", "Mem:", "Time:", "Remaining:")


#: What ended a render. A target is reached with a confidence of 95 %, however often it looked.
ENDINGS = {
    "samples": "ended at the samples",
    "target": "ended at the target error, with 95 % confidence",
    "time": "ended at the time limit",
    "cancel": "cancelled",
    "failure": "failed",
}


def engine_text(text: str) -> str:
    """The engine's own part of a statistics line of Blender's."""
    parts = [part for part in text.split(" | ") if not part.startswith(BLENDER_PREFIXES)]
    return " | ".join(parts)


def warnings(records: Sequence[RenderRecord]) -> list[str]:
    """What was approximated or left out, each message once."""
    return list(dict.fromkeys(text for record in records for text in record.messages))


def lines(records: Sequence[RenderRecord], path: Path, frame_seconds: float) -> list[str]:
    """One line for each view layer of the frame, then what was written where.

    `frame_seconds` is the time of the whole operation, by the clock.
    """
    text = []
    for record in records:
        progress = record.progress
        parts = [
            f"{progress.samples:.6g} samples per pixel",
            f"{progress.seconds:.2f} s",
            f"{count(progress.rays / progress.seconds if progress.seconds else 0)} rays/s",
            f"error {error_text(progress.error)}",
            ENDINGS[progress.ending],
        ]
        if progress.non_finite:
            parts.append(f"{progress.non_finite} samples dropped as not finite")
        name = f"{record.layer}: " if len(records) > 1 else ""
        text.append(name + ", ".join(parts))
        if record.choice:
            text.append(f"{name}Auto: {record.choice}")
        text += [name + line for line in record.modelled.lines()]
    peak = status_bytes("VmHWM") / 2**20
    text.append(f"{frame_seconds:.2f} s in all, {peak:.0f} MiB at the peak, written to {path}")
    return text


def error_text(error: float) -> str:
    """The picture's error: a 95 % confidence half-width, relative."""
    if not math.isfinite(error):
        return "unknown (too few samples)"
    percent = 100 * error
    return f"{percent:.0f} %" if percent >= 10 else f"{percent:.2g} %"


def count(value: float) -> str:
    """Three digits and a unit: 812, 3.20 k, 14.5 M."""
    for limit, unit in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if value >= limit:
            return f"{value / limit:.3g}{unit}"
    return f"{value:.3g}"
