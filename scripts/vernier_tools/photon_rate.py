"""The process that measures photons; `jobs.run_photon_rate` starts it.

On one thread: a map of about `photons` photons, traced, stored and indexed, beside a million camera
paths; and the nearest photons of many points, beside SciPy's own tree of the same points. All take
turns, and the best of each counts.

Usage: python -m vernier_tools.photon_rate JOB.json RATE.json
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
from scipy.spatial import cKDTree

import engine_core
from engine_core import probe
from vernier_tools import engines
from vernier_tools.capture import Capture
from vernier_tools.errors import ToolError
from vernier_tools.jobs import Job, PhotonRate
from vernier_tools.worker import answer, scene_of

MILLION = 1_000_000
#: Each asks for so many of the nearest, and photons themselves are where it is asked.
QUERIES, NEIGHBOURS = 50_000, 50
#: Of these the number of photons that a path leaves is told.
PILOT = 1 << 15
TURNS = 3
FAR = 1e15


def seconds_of(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def camera_seconds(scene: engine_core.Scene, settings: dict[str, Any]) -> float:
    """Processor time of a million paths from the camera."""
    pixels = int(scene.width * scene.height)
    samples = -(-MILLION // pixels)
    session = engine_core.Session(scene, {**settings, "samples": samples}, ["Combined"])
    start = time.process_time()
    session.start()
    while not session.wait(60.0):
        pass
    seconds: float = time.process_time() - start
    if session.error_message:
        raise ToolError(session.error_message)
    return seconds * MILLION / (samples * pixels)


def work(job: Job, _capture: Capture) -> PhotonRate:
    """Measures photons of the job's scene. Raises ToolError."""
    from addon.export import export_scene
    from addon.settings import render_settings

    blender_scene = scene_of(job)
    engines.set_up(blender_scene, job, job.seeds[0])
    description, _ = export_scene(bpy.context.evaluated_depsgraph_get())
    settings = render_settings(blender_scene, bpy.context.view_layer)
    settings |= {"integrator": "PATH", "threads": 1, "time_limit": 0.0}
    scene = engine_core.compile(description, threads=1)
    pilot = probe.build_photon_map(scene, settings, PILOT, 1)
    if not pilot["photons"]:
        raise ToolError("no path from the lights leaves a photon")
    paths = -(-job.photons * PILOT // pilot["photons"])
    points = probe.trace_photons(scene, settings, paths, 2)["photons"][:, :3].astype(np.float32)
    rng = np.random.default_rng(3)
    asked = np.ascontiguousarray(rng.permutation(points)[:QUERIES])
    own, other = probe.KdTree(points, 1), cKDTree(points)
    built: dict[str, Any] = {}
    best = dict.fromkeys(("map", "camera", "tree", "scipy"), float("inf"))
    for _ in range(TURNS):
        for name, measure in (
            ("map", lambda: built.update(probe.build_photon_map(scene, settings, paths, 2))),
            ("tree", lambda: own.nearest(asked, NEIGHBOURS, FAR)),
            ("scipy", lambda: other.query(asked, k=NEIGHBOURS, workers=1)),
        ):
            best[name] = min(best[name], seconds_of(measure))
        best["camera"] = min(best["camera"], camera_seconds(scene, settings))
    return PhotonRate(
        photons=built["photons"],
        paths=built["paths"],
        bytes_of_photon=built["memory"] / built["photons"],
        map_seconds=best["map"] * MILLION / built["photons"],
        camera_seconds=best["camera"],
        query_seconds=best["tree"] / len(asked),
        scipy_seconds=best["scipy"] / len(asked),
    )


if __name__ == "__main__":
    answer(work)
