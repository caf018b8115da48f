"""Renders a .blend file with Vernier, through the add-on, as F12 in Blender does."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vernier_tools import command_lines, settings
from vernier_tools.errors import ToolError
from vernier_tools.progress import ProgressLine

if TYPE_CHECKING:
    import bpy

    from addon.record import RenderRecord
    from vernier_tools.capture import Capture

COMMAND = "scripts/render"


def configure(scene: bpy.types.Scene, options: argparse.Namespace) -> None:
    """Applies the command line to the scene. Raises ToolError."""
    scene.render.engine = "VERNIER"
    if options.threads:
        scene.render.threads_mode = "FIXED"
        scene.render.threads = options.threads
    if options.resolution:
        scene.render.resolution_x, scene.render.resolution_y = options.resolution
        scene.render.resolution_percentage = 100
    if options.frame is not None:
        scene.frame_set(options.frame)
    values: dict[str, Any] = {}
    if options.integrator:
        values["integrator"] = options.integrator
    if options.time is not None:
        values["time_limit"] = options.time
        values["samples"] = settings.most("samples")
    if options.target_error is not None:
        values["target_error"] = options.target_error
        values["samples"] = settings.most("samples")
    if options.checkpoint is not None:
        values["checkpoint"] = str(options.checkpoint.absolute())
        values["resume"] = options.resume
    if options.samples is not None:
        values["samples"] = options.samples
    if options.seed is not None:
        values["seed"] = options.seed
    values.update(options.assignments)
    settings.apply(scene.vernier, values)


def render_frame(
    scene: bpy.types.Scene, path: Path, prefix: str, progress: ProgressLine
) -> list[RenderRecord]:
    """Renders and saves one frame; returns the engine's records of it. Raises ToolError."""
    import bpy

    from vernier_tools import outputs, summary
    from vernier_tools.blend_file import require_camera
    from vernier_tools.measure import RenderWatch

    require_camera(scene)
    with RenderWatch(lambda text: progress.show(prefix + summary.engine_text(text))) as watch:
        try:
            done = bpy.ops.render.render()
        except RuntimeError as error:
            raise ToolError(str(error).strip().removeprefix("Error: ")) from error
        finally:
            progress.clear()
    if done != {"FINISHED"} or not watch.records:
        raise ToolError("the render ended without a picture")
    outputs.save_render(scene, path)
    return watch.records


def render(options: argparse.Namespace, capture: Capture) -> None:
    """Does all of it. Raises ToolError; then no output of an unfinished frame was touched."""
    from vernier_tools import outputs, summary
    from vernier_tools.blend_file import open_blend, require_camera
    from vernier_tools.engines import enable_cycles, register_vernier

    outputs.check_output(options.output)
    # Without Cycles' properties registered, what the file says in them would not be read.
    enable_cycles()
    register_vernier()
    scene = open_blend(options.scene)
    configure(scene, options)
    require_camera(scene)
    progress = ProgressLine(capture.terminal_error)
    frames = options.frames or range(scene.frame_current, scene.frame_current + 1)
    warned: set[str] = set()
    for number, frame in enumerate(frames, 1):
        start = time.perf_counter()
        prefix, path = "", options.output
        if options.frames:
            scene.frame_set(frame)
            prefix = f"Frame {frame} ({number} of {len(frames)}) | "
            path = outputs.frame_path(options.output, frame)
        records = render_frame(scene, path, prefix, progress)
        for warning in summary.warnings(records):
            if warning not in warned:
                warned.add(warning)
                print(f"{COMMAND}: warning: {warning}", file=capture.terminal_error, flush=True)
        lines = summary.lines(records, path, time.perf_counter() - start)
        print("\n".join(lines), file=capture.terminal, flush=True)


def main() -> None:
    options = command_lines.render(sys.argv[1:])
    from vernier_tools.capture import Capture

    capture = Capture()
    # Blender swallows exceptions inside a render, KeyboardInterrupt too, so it ends here. Pictures
    # are only ever renamed into place whole.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda received, _frame: interrupted(capture, received))
    code = 0
    try:
        render(options, capture)
    except ToolError as error:
        capture.report(COMMAND, error)
        code = 1
    except Exception as error:
        capture.terminal_error.write(capture.text())
        capture.report(COMMAND, f"{type(error).__name__}: {error}")
        code = 1
    leave(capture, code)


def interrupted(capture: Capture, number: int) -> None:
    save_checkpoint()
    # Past the stream: the signal may have come while that was writing, and then it writes no more.
    os.write(capture.terminal_error.fileno(), f"{COMMAND}: error: interrupted\n".encode())
    os._exit(128 + number)


def save_checkpoint() -> None:
    """Of the render that is under way, where one was asked for."""
    module = sys.modules.get("addon.checkpoint")
    if module is not None:
        module.save_active()


def leave(capture: Capture, code: int) -> None:
    """Ends the process without the interpreter's shutdown, in which Blender 4.5 hangs."""
    capture.flush()
    os._exit(code)


if __name__ == "__main__":
    main()
