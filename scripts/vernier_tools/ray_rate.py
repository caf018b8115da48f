"""The process that measures how near Vernier comes to Embree alone; `jobs.run_ray_rate` starts it.

The scene is rendered on one thread, once to be timed and once with every ray recorded; then Embree
casts the recorded rays with nothing in between. Renders and casts take turns, and the best of each
counts: what disturbs them only makes them slower.

Usage: python -m vernier_tools.ray_rate JOB.json RATE.json
"""

from __future__ import annotations

import time
from typing import Any

import bpy

import engine_core
from vernier_tools import engines
from vernier_tools.capture import Capture
from vernier_tools.errors import ToolError
from vernier_tools.jobs import Job, RayRate
from vernier_tools.worker import answer, scene_of

# Rays that are recorded, 64 bytes each.
CAPACITY = 3_000_000
TURNS = 3


def rendered(description: Any, settings: dict[str, Any]) -> tuple[Any, int, float]:
    """Compiles and renders; the scene, its rays, and the processor seconds that these took."""
    scene = engine_core.compile(description)
    session = engine_core.Session(scene, settings, ["Combined"])
    start = time.process_time()
    session.start()
    while not session.wait(60.0):
        pass
    seconds = time.process_time() - start
    if session.error_message:
        raise ToolError(session.error_message)
    return scene, session.poll().rays, seconds


def work(job: Job, _capture: Capture) -> RayRate:
    """Measures the rates on the job's scene. Raises ToolError."""
    from addon.export import export_scene
    from addon.settings import render_settings

    scene = scene_of(job)
    engines.set_up(scene, job, job.seeds[0])
    depsgraph = bpy.context.evaluated_depsgraph_get()
    description, _ = export_scene(depsgraph)
    settings = render_settings(scene, bpy.context.view_layer)
    settings |= {"threads": 1, "samples": 1, "time_limit": 0.0}
    _, rays, _ = rendered(description, settings)
    if not rays:
        raise ToolError("the scene has no rays to cast")
    settings["samples"] = max(1, CAPACITY // rays)
    engine_core.start_recording(2 * CAPACITY)
    recorded, _, _ = rendered(description, settings)
    engine_core.stop_recording()
    best_render, best_cast = 0.0, 0.0
    for _ in range(TURNS):
        _, rays, seconds = rendered(description, settings)
        best_render = max(best_render, rays / seconds)
        start = time.thread_time()
        cast, _, _ = engine_core.replay()
        best_cast = max(best_cast, cast / (time.thread_time() - start))
    del recorded  # the rays were of its Embree scenes
    return RayRate(cast, best_render, best_cast)


if __name__ == "__main__":
    answer(work)
