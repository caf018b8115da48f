"""Renders by the core alone, and what is read of them."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vernier_tools.calibration import Array, scale
from vernier_tools.errors import ToolError

if TYPE_CHECKING:
    from engine_core.description import SceneDescription

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True)
class CoreRender:
    """Luminances and their stated half-widths by row and column; processor seconds of all threads,
    the choice of a method included; `error` is the picture's, as stated."""

    values: Array
    halves: Array
    error: float
    samples: float
    seconds: float
    ending: str
    integrator: str
    choice: str


def compiled(description: SceneDescription) -> Any:
    import engine_core

    return engine_core.compile(description, threads=0)


def rendered(scene: Any, integrator: str, seed: int, **settings: Any) -> CoreRender:
    """Renders a compiled scene. Raises ToolError when that fails."""
    import engine_core

    start = time.process_time()
    values = {"integrator": integrator, "seed": seed, "samples": 1 << 24, **settings}
    session = engine_core.Session(scene, values, ["Combined", "Error"])
    session.start()
    while not session.wait(10.0):
        pass
    seconds = time.process_time() - start
    if session.error_message:
        raise ToolError(f"{integrator}: {session.error_message}")
    area = (0, 0, scene.width, scene.height)
    color = np.asarray(session.read("Combined", *area), np.float64)[..., :3] @ LUMINANCE
    errors = np.asarray(session.read("Error", *area), np.float64)[..., 0]
    progress = session.poll(True)
    with np.errstate(invalid="ignore"):  # nothing is known of a black picture's pixels
        halves = errors * scale(color)
    return CoreRender(
        color,
        halves,
        progress.error,
        progress.samples,
        seconds,
        progress.ending,
        session.integrator,
        session.choice,
    )
