"""Renders that are ended at any moment leave no thread and no memory behind."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from scenes import SceneBuilder, background, diffuse, placed, quad, sphere

import engine_core

INTEGRATORS = [
    identifier
    for parameter in engine_core.parameters()
    if parameter.name == "integrator"
    for identifier, *_ in parameter.items
]
MEBIBYTE = 1 << 20


def scene() -> SceneBuilder:
    builder = SceneBuilder((64, 64))
    builder.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.6))
    builder.add(sphere(0.8, (0, 0, 0.8), rings=64), diffuse(0.5))
    builder.light("POINT", transform=placed(1.0, (2, -2, 3)), emission=(60.0,) * 3, radius=0.1)
    builder.description.world = background(0.3)
    builder.camera((0, -6, 3), (0, 0, 0.6))
    return builder


def threads() -> int:
    return len(list(Path("/proc/self/task").iterdir()))


def resident() -> int:
    """Bytes of this process's memory that are in use."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


def render_until(moment: float, integrator: str) -> None:
    """Compiles, renders and cancels after `moment` seconds; everything is then let go."""
    compiled = engine_core.compile(scene().description, threads=2)
    options = {"integrator": integrator, "samples": 1 << 20, "threads": 2}
    session = engine_core.Session(compiled, options, ["Combined"])
    session.start()
    time.sleep(moment)
    session.cancel()
    assert session.wait(60.0), "the render did not end"
    assert session.error_message == ""


def test_a_hundred_cancelled_renders_leave_no_thread() -> None:
    render_until(0.01, "PATH")  # what is kept for the process is there
    before = threads()
    moments = np.random.default_rng(11).uniform(0.0, 0.05, 100)
    for number, moment in enumerate(moments):
        render_until(float(moment), INTEGRATORS[number % len(INTEGRATORS)])
    assert threads() <= before


@pytest.mark.parametrize("integrator", ["PATH", "BDPT"])
def test_two_hundred_renders_leave_no_memory(integrator: str) -> None:
    """A scene with its hierarchy has several megabytes: one that stayed a time would be seen."""
    options = {"integrator": integrator, "samples": 1, "threads": 2}

    def render() -> None:
        compiled = engine_core.compile(scene().description, threads=2)
        session = engine_core.Session(compiled, options, ["Combined"])
        session.start()
        assert session.wait(60.0)

    for _ in range(40):
        render()
    before = resident()
    for _ in range(160):
        render()
    assert resident() - before < 16 * MEBIBYTE
