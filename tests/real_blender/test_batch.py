"""Rendering from Blender's command line, as render farms do it."""

from __future__ import annotations

import re
import subprocess
import time
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from .conftest import redness
from .machine import Machine

PROGRESS = re.compile(
    r"^Fra:(\d+) Mem:[\d.]+M \(Peak [\d.]+M\) \| Time:[\d:.]+( \| Remaining:[\d:.]+)? \| "
    r"Scene, ViewLayer \| Sample (\d+)/(\d+)",
    re.MULTILINE,
)


@pytest.fixture(scope="module")
def folder(machine: Machine, profile: Path) -> Path:
    """A folder with `red.blend`: the default scene with a red cube that moves, small."""
    result = machine.outside / "batch"
    result.mkdir()
    result.chmod(0o777)
    script = result / "make.py"
    script.write_text(
        f"""
import bpy
scene = bpy.context.scene
scene.render.resolution_x, scene.render.resolution_y = 160, 90
scene.frame_end = 4
cube = bpy.data.objects["Cube"]
cube.keyframe_insert("location", frame=1)
cube.location.z = 1.5
cube.keyframe_insert("location", frame=4)
shader = cube.active_material.node_tree.nodes["Principled BSDF"]
shader.inputs["Base Color"].default_value = (0.8, 0.02, 0.02, 1.0)
# The engine is chosen by the command line; its settings can be in the file all the same.
scene.vernier.samples = 8
bpy.ops.wm.save_as_mainfile(filepath={machine.path(result / "red.blend")!r})
scene.camera = None
bpy.ops.wm.save_as_mainfile(filepath={machine.path(result / "blind.blend")!r}, copy=True)
"""
    )
    done = machine.run_blender(
        ["--python-exit-code", "9", "--python", machine.path(script)], profile
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return result


def render(
    machine: Machine, profile: Path, scene: Path, *arguments: str
) -> subprocess.CompletedProcess[str]:
    command = [machine.path(scene), "--engine", "VERNIER", *arguments]
    return machine.run_blender(command, profile)


def read(path: Path) -> np.ndarray:
    buffer = OpenImageIO.ImageBuf(str(path))
    assert not buffer.has_error, buffer.geterror()
    return np.asarray(buffer.get_pixels(OpenImageIO.FLOAT))


def test_one_frame(machine: Machine, profile: Path, folder: Path) -> None:
    done = render(machine, profile, folder / "red.blend", "-o", "//one_####", "-f", "3")
    assert done.returncode == 0, done.stdout + done.stderr
    pixels = read(folder / "one_0003.png")
    assert pixels.shape[:2] == (90, 160)
    assert 0.02 < redness(pixels) < 0.3
    lines = PROGRESS.findall(done.stdout)
    assert lines, done.stdout
    assert {frame for frame, *_ in lines} == {"3"}
    assert lines[-1][2:] == ("8", "8")


def test_settings_on_the_command_line(machine: Machine, profile: Path, folder: Path) -> None:
    arguments = ["-o", "//whitted_####", "-f", "1", "--", "--other-add-on", "x"]
    arguments += ["--vernier-integrator", "whitted", "--vernier-samples=3"]
    done = render(machine, profile, folder / "red.blend", *arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    assert PROGRESS.findall(done.stdout)[-1][2:] == ("3", "3")


def test_a_time_limit(machine: Machine, profile: Path, folder: Path) -> None:
    start = time.monotonic()
    arguments = ["-o", "//time_####", "-f", "1", "--", "--vernier-time", "2"]
    done = render(machine, profile, folder / "red.blend", *arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    assert time.monotonic() - start > 2.0
    samples = int(PROGRESS.findall(done.stdout)[-1][2])
    assert samples > 8  # the file's number does not end it


@pytest.mark.parametrize(
    ("scene", "arguments", "sentence"),
    [
        ("blind.blend", [], "no camera"),
        ("red.blend", ["--vernier-samples", "many"], "'many' is not a whole number from 1 to"),
        ("red.blend", ["--vernier-sample", "3"], "there is no option --vernier-sample"),
        ("red.blend", ["--vernier-integrator", "magic"], "'magic' is not one of path"),
    ],
)
def test_failures_end_with_a_code(
    machine: Machine,
    profile: Path,
    folder: Path,
    scene: str,
    arguments: list[str],
    sentence: str,
) -> None:
    done = render(machine, profile, folder / scene, "-o", "//no_####", "-f", "1", "--", *arguments)
    assert done.returncode != 0
    text = done.stdout + done.stderr
    assert sentence in text
    assert "Traceback" not in text


def test_processes_share_an_animation(machine: Machine, profile: Path, folder: Path) -> None:
    """Blender's place-holders keep two processes from rendering the same frame."""
    script = folder / "share.py"
    script.write_text(
        """
import bpy
render = bpy.context.scene.render
render.use_placeholder, render.use_overwrite = True, False
"""
    )
    arguments = [machine.blender, "--background", machine.path(folder / "red.blend")]
    arguments += ["--engine", "VERNIER", "--python", machine.path(script), "-o", "//shared_####"]
    arguments += ["-a"]
    variables = {"BLENDER_USER_RESOURCES": machine.path(profile)}
    processes = [
        subprocess.Popen(
            machine.command(arguments, variables),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        for _ in range(2)
    ]
    texts = [process.communicate(timeout=300.0)[0] for process in processes]
    assert [process.returncode for process in processes] == [0, 0], texts
    frames = [{frame for frame, *_ in PROGRESS.findall(text)} for text in texts]
    assert frames[0] | frames[1] == {"1", "2", "3", "4"}
    assert not frames[0] & frames[1], "a frame was rendered twice"
    heights = []
    for number in range(1, 5):
        pixels = read(folder / f"shared_{number:04d}.png")
        red = pixels[..., 0] > 1.5 * pixels[..., 1]
        heights.append(float(np.argwhere(red)[:, 0].mean()))
    assert heights == sorted(heights, reverse=True), "the cube rises"
