"""The process in which one engine renders one job; `jobs.run` starts it.

Usage: python -m vernier_tools.worker JOB.json OUTCOME.json
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import bpy

from vernier_tools import engines, generated_scenes, outputs
from vernier_tools.blend_file import open_blend, require_camera
from vernier_tools.capture import Capture
from vernier_tools.errors import ToolError
from vernier_tools.jobs import Job, Outcome, PhotonRate, RayRate, job_from_json
from vernier_tools.measure import render_measured


def scene_of(job: Job) -> bpy.types.Scene:
    """Opens or makes the job's scene. Raises ToolError."""
    # Vernier needs Cycles' properties too: what the file says of the film is in them.
    engines.enable_cycles()
    made = job.generated
    scene = generated_scenes.make(made) if made else open_blend(Path(job.blend))
    require_camera(scene)
    return scene


def work(job: Job, capture: Capture) -> Outcome:
    """Renders the job with its engine. Raises ToolError."""
    scene = scene_of(job)
    renders = []
    warnings: dict[str, None] = {}
    for seed in job.seeds:
        engines.set_up(scene, job, seed)
        render, records = render_measured(seed)
        renders.append(render)
        warnings |= dict.fromkeys(text for record in records for text in record.messages)
        if job.output:
            outputs.save_render(scene, Path(f"{job.output}-{seed}.exr"))
            if job.view:
                outputs.save_render(scene, Path(f"{job.output}-{seed}.png"))
    percentage = scene.render.resolution_percentage
    return Outcome(
        engine=job.engine,
        version=bpy.app.version_string,
        width=scene.render.resolution_x * percentage // 100,
        height=scene.render.resolution_y * percentage // 100,
        triangles=count_triangles(),
        renders=tuple(renders),
        warnings=tuple(warnings or capture.messages("Warning")),
    )


def count_triangles() -> int:
    """The triangles that the scene's objects show, every instance counted."""
    count = 0
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        data = instance.object.data
        if instance.object.type == "MESH" and data is not None:
            count += len(data.loops) - 2 * len(data.polygons)
    return count


def answer(work: Callable[[Job, Capture], Outcome | RayRate | PhotonRate]) -> None:
    """Does the job of the first file named on the command line, writes the second, and ends.

    The last line of an unsuccessful process's standard error is the reason.
    """
    capture = Capture()
    code = 0
    try:
        job = job_from_json(json.loads(Path(sys.argv[1]).read_text()))
        Path(sys.argv[2]).write_text(json.dumps(asdict(work(job, capture))))
    except ToolError as error:
        print(capture.text(), file=capture.terminal_error)
        print(f"{error}", file=capture.terminal_error)
        code = 1
    except Exception as error:
        print(capture.text(), file=capture.terminal_error)
        print(f"{type(error).__name__}: {error}", file=capture.terminal_error)
        code = 1
    capture.terminal_error.flush()
    # Blender 4.5 hangs when its interpreter shuts down.
    os._exit(code)


if __name__ == "__main__":
    answer(work)
