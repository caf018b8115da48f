"""Runs one render operation and measures it: times, samples, processor time, memory."""

from __future__ import annotations

import math
import re
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from vernier_tools.errors import ToolError
from vernier_tools.jobs import Render

if TYPE_CHECKING:
    from addon.record import RenderRecord

# Both engines' statistics lines hold "Sample 12/64".
SAMPLE = re.compile(r"Sample (\d+)")


class RenderWatch:
    """Follows a render operation: its statistics lines, and what Vernier records of itself.

    Cycles tells of its samples in the statistics lines alone.
    """

    def __init__(self, listener: Callable[[str], None] | None = None) -> None:
        self.listener = listener
        self.records: list[RenderRecord] = []
        self.listeners: list[Callable[[RenderRecord], None]] = []
        self.start = time.perf_counter()
        self.first_sample = 0.0
        self.first_sample_cpu = 0.0
        self.first_tile = 0.0
        self.last_tile = 0.0
        self.samples = 0.0

    def __enter__(self) -> RenderWatch:
        self.listeners = record_listeners()
        self.listeners.append(self.on_record)
        bpy.app.handlers.render_stats.append(self.on_stats)
        self.start = time.perf_counter()
        return self

    def __exit__(self, *exception: object) -> None:
        bpy.app.handlers.render_stats.remove(self.on_stats)
        self.listeners.remove(self.on_record)

    def on_record(self, record: RenderRecord) -> None:
        self.records.append(record)

    def on_stats(self, text: str, _unused: object = None) -> None:
        if self.listener:
            self.listener(text)
        found = SAMPLE.search(text)
        if not found:
            return
        now = time.perf_counter() - self.start
        samples = int(found[1])
        if not self.first_sample:
            self.first_sample = now
            self.first_sample_cpu = processor_seconds()
        # Cycles counts from 0 again at its end.
        if samples > self.samples:
            self.first_tile = self.first_tile or now
            self.last_tile = now
            self.samples = samples

    def use_records(self) -> None:
        """Takes times and samples from Vernier's records, which are exact."""
        if not self.records:
            return
        self.first_sample = self.records[0].compiled - self.start
        self.first_tile = self.records[0].first_tile - self.start
        self.last_tile = self.first_sample + sum(r.progress.seconds for r in self.records)
        self.samples = self.records[0].progress.samples


def record_listeners() -> list[Callable[[RenderRecord], None]]:
    """The add-on's list of those to be told of a finished render; empty and unused without it."""
    module = sys.modules.get("addon.record")
    found: list[Callable[[RenderRecord], None]] = module.listeners if module else []
    return found


def reset_peak_memory() -> int:
    """Makes the kernel count the peak anew; returns the memory in use now, in bytes."""
    Path("/proc/self/clear_refs").write_text("5")
    return status_bytes("VmRSS")


def status_bytes(field: str) -> int:
    """A field of /proc/self/status that is given in kB, such as VmHWM, in bytes."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(field + ":"):
            return int(line.split()[1]) * 1024
    raise ToolError(f"the kernel does not tell {field}")


def processor_seconds() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def render_measured(seed: int) -> tuple[Render, list[RenderRecord]]:
    """Renders the context's scene and measures it; with what Vernier recorded.

    Raises ToolError when the engine fails.
    """
    memory = reset_peak_memory()
    start = processor_seconds()
    with RenderWatch() as watch:
        try:
            done = bpy.ops.render.render()
        except RuntimeError as error:
            raise ToolError(f"the render failed: {str(error).strip()}") from error
        seconds = time.perf_counter() - watch.start
    end = processor_seconds()
    if done != {"FINISHED"}:
        raise ToolError("the render was cancelled")
    watch.use_records()
    if not watch.samples:
        raise ToolError("the engine never told of a sample")
    peak = status_bytes("VmHWM")
    render = Render(
        seed=seed,
        seconds=seconds,
        cpu=end - start,
        sampling_cpu=end - watch.first_sample_cpu,
        first_sample=watch.first_sample,
        first_tile=watch.first_tile,
        sampling=watch.last_tile - watch.first_sample,
        samples=watch.samples,
        memory=max(peak - memory, 0),
        peak_memory=peak,
        rays=sum(record.progress.rays for record in watch.records),
        error=max((record.progress.error for record in watch.records), default=math.inf),
    )
    return render, watch.records
