"""`scripts/render`: what it writes, what it says, and that it fails cleanly."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from tool_process import CORNELL_BOX, Tool
from vernier_tools import images, settings, summary

QUICK = ["--samples", "4", "--resolution", "32x24", "--threads", "2"]


def channels(path: Path) -> list[str]:
    source = OpenImageIO.ImageInput.open(str(path))
    assert source is not None
    assert source.spec().format == OpenImageIO.FLOAT
    return list(source.spec().channelnames)


def test_exr_is_linear_float_with_passes_and_the_summary_says_all(
    tool: Tool, tmp_path: Path
) -> None:
    done = tool("render", CORNELL_BOX, "-o", "a.exr", *QUICK)
    assert done.returncode == 0, done.stderr
    assert "ViewLayer.Combined.R" in channels(tmp_path / "a.exr")
    picture = images.read_combined(tmp_path / "a.exr")
    assert picture.shape == (24, 32, 3)
    assert np.isfinite(picture).all()
    assert picture.mean() > 0.01
    summary_lines = done.stdout.splitlines()
    assert re.fullmatch(
        r"4 samples per pixel, [\d.]+ s, [\d.]+( [kMG])? rays/s, error .*, ended at the samples",
        summary_lines[0],
    )
    assert summary_lines[1].startswith("Auto: Path tracing: ")
    assert summary_lines[2].startswith("Modelled: ")
    assert "instancing" in summary_lines[3]
    assert re.fullmatch(
        r"[\d.]+ s in all, \d+ MiB at the peak, written to a\.exr", summary_lines[4]
    )
    assert len(summary_lines) == 5
    # Nothing else is left in the folder.
    assert [path.name for path in tmp_path.iterdir()] == ["a.exr"]


def test_a_resumed_render_ends_at_a_tighter_target_as_one_render_would(
    tool: Tool, tmp_path: Path
) -> None:
    common = [CORNELL_BOX, "--resolution", "32x24", "--threads", "2", "--integrator", "path"]
    state = ["--checkpoint", "a.state"]
    first = tool("render", *common, *state, "-o", "a.exr", "--target-error", "250%")
    assert first.returncode == 0, first.stderr
    assert "ended at the target error, with 95 % confidence" in first.stdout
    again = tool("render", *common, *state, "--resume", "-o", "b.exr", "--target-error", "120")
    once = tool("render", *common, "-o", "c.exr", "--target-error", "120")
    assert again.stdout.split(" samples")[0] == once.stdout.split(" samples")[0]
    pictures = [images.read_combined(tmp_path / name) for name in ("b.exr", "c.exr")]
    assert np.array_equal(*pictures)
    # The file tells how it came about.
    header = (tmp_path / "c.exr").read_bytes()[:20000]
    assert b"ended by" in header
    assert b"target" in header
    other = tool("render", *common, *state, "--resume", "-o", "d.exr", "--seed", "3")
    assert other.returncode == 1
    assert "is of a render with other settings" in other.stderr


def test_an_interrupted_render_leaves_its_state(tool: Tool, tmp_path: Path) -> None:
    common = [CORNELL_BOX, "--resolution", "32x24", "--threads", "2"]
    command = [sys.executable, "-m", "vernier_tools.render", *map(str, common), "-o", "a.exr"]
    process = subprocess.Popen(
        [*command, "--samples", "16000000", "--integrator", "path", "--checkpoint", "a.state"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    try:
        samples = 0
        while samples < 4:
            line = process.stderr.readline()
            assert line, "ended before it rendered"
            found = re.search(r"Sample (\d+)/", line)
            samples = int(found[1]) if found else samples
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
    finally:
        process.kill()
    assert (tmp_path / "a.state").stat().st_size > 32 * 24 * 50
    done = tool(
        "render", *common, "--integrator", "path", "-o", "b.exr", "--samples", "1",
        *("--checkpoint", "a.state", "--resume"),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert float(done.stdout.split()[0]) > 1


def test_png_goes_through_the_view_transform(tool: Tool, tmp_path: Path) -> None:
    for name in ("a.exr", "a.png", "b.png"):
        assert tool("render", CORNELL_BOX, "-o", name, *QUICK).returncode == 0
    linear = images.read_combined(tmp_path / "a.exr")
    shown = images.read_combined(tmp_path / "a.png")
    # The scene's view transform is Standard, the sRGB curve, after one factor for the exposure.
    decoded = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    inside = (shown > 0.3) & (shown < 0.9)
    assert inside.mean() > 0.1
    factor = decoded[inside] / linear[inside]
    # Bytes, dithered by up to a step: 2.4 / (0.3 * 255) is 3 % a step at the dark end.
    np.testing.assert_allclose(factor, np.median(factor), rtol=0.06)
    # The same seed gives the same picture.
    np.testing.assert_array_equal(shown, images.read_combined(tmp_path / "b.png"))


def test_seeds_differ_and_every_option_reaches_the_engine(tool: Tool, tmp_path: Path) -> None:
    common = [CORNELL_BOX, *QUICK[2:]]
    assert tool("render", *common, "-o", "a.exr", "--samples", 4, "--seed", 7).returncode == 0
    done = tool(
        "render", *common, "-o", "b.exr", "--set", "seed=8", "--set", "samples=3",
        "--integrator", "path", "--set", "direct_light=bsdf",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("3 samples per pixel")
    first, second = (images.read_combined(tmp_path / name) for name in ("a.exr", "b.exr"))
    assert not np.array_equal(first, second)


def test_time_alone_ends_a_render(tool: Tool) -> None:
    done = tool("render", CORNELL_BOX, "-o", "a.png", "--time", 0.5, *QUICK[2:])
    assert done.returncode == 0, done.stderr
    samples = float(done.stdout.split()[0])
    # Far more than the samples that the file asks for take less than this on such a picture.
    assert samples > 4


def test_frames_are_numbered(tool: Tool, tmp_path: Path) -> None:
    done = tool("render", CORNELL_BOX, "-o", "f_###.png", "--frames", "9-10", *QUICK)
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["f_009.png", "f_010.png"]
    assert "Frame 9 (1 of 2)" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere.blend", "-o", "a.png"], "nowhere.blend: No such file or directory"),
        ([CORNELL_BOX], "required: -o/--output"),
        ([CORNELL_BOX, "-o", "a.gif"], "the name must end in one of .exr"),
        ([CORNELL_BOX, "-o", "nowhere/a.png"], "the folder nowhere does not exist"),
        ([CORNELL_BOX, "-o", "a.png", "--samples", "0"], "samples: '0' is not a whole number"),
        ([CORNELL_BOX, "-o", "a.png", "--time", "soon"], "time_limit: 'soon' is not a number"),
        ([CORNELL_BOX, "-o", "a.png", "--integrator", "magic"], "'magic' is not one of path,"),
        ([CORNELL_BOX, "-o", "a.png", "--set", "magic=1"], "there is no setting 'magic'"),
        ([CORNELL_BOX, "-o", "a.png", "--set", "samples"], "'samples' is not KEY=VALUE"),
        ([CORNELL_BOX, "-o", "a.png", "--frames", "9-3"], "'9-3' is not FIRST-LAST"),
        ([CORNELL_BOX, "-o", "a.png", "--frame", "1", "--frames", "1-2"], "not allowed with"),
        ([CORNELL_BOX, "-o", "a.png", "--resolution", "2x2"], "is not WIDTHxHEIGHT"),
        ([CORNELL_BOX, "-o", "a.png", "--samplez", "4"], "unrecognized arguments"),
    ],
)
def test_bad_calls_are_one_line_and_write_nothing(
    tool: Tool, tmp_path: Path, arguments: list[str], message: str
) -> None:
    done = tool("render", *arguments)
    assert done.returncode != 0
    assert done.stdout == ""
    assert done.stderr.startswith("scripts/render: error: ")
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"hello, world\n", "not a .blend file"),
        (b"", "not a .blend file"),
        (None, "the file is damaged"),
    ],
)
def test_damaged_files_are_one_line(
    tool: Tool, tmp_path: Path, content: bytes | None, message: str
) -> None:
    broken = tmp_path / "broken.blend"
    broken.write_bytes(CORNELL_BOX.read_bytes()[:20_000] if content is None else content)
    done = tool("render", broken, "-o", "a.png")
    assert done.returncode == 1
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "a.png").exists()


def test_a_scene_without_a_camera_is_one_line(tool: Tool, tmp_path: Path) -> None:
    script = (
        "import bpy, os; bpy.ops.wm.read_factory_settings(use_empty=True);"
        "bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath('empty.blend'));"
        "os._exit(0)"
    )
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, capture_output=True)
    done = tool("render", "empty.blend", "-o", "a.png")
    assert done.returncode == 1
    assert done.stderr == 'scripts/render: error: the scene "Scene" has no camera\n'


def test_an_output_that_is_there_stays_when_the_render_is_interrupted(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("before")
    command = [sys.executable, "-m", "vernier_tools.render", str(CORNELL_BOX), "-o", "a.png"]
    process = subprocess.Popen(
        [*command, "--samples", "1000000"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    samples = 0
    while samples < 4:
        line = process.stderr.readline()
        assert line, "ended before it rendered"
        found = re.search(r"Sample (\d+)/", line)
        samples = int(found[1]) if found else samples
    time.sleep(0.2)
    os.kill(process.pid, signal.SIGINT)
    _, error = process.communicate(timeout=60)
    assert process.returncode == 128 + signal.SIGINT
    assert error.splitlines()[-1] == "scripts/render: error: interrupted"
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("a.png", "before")]


def test_the_help_lists_every_setting(tool: Tool) -> None:
    done = tool("render", "--help")
    assert done.returncode == 0
    for name in settings.table():
        assert f"  {name} (" in done.stdout


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("Remaining: 00:01 | Mem: 1M | Sample 1/8 | Time left 0:02", "Sample 1/8 | Time left 0:02"),
        (
            "Fra:1 Mem:9M (Peak 9M) | Time:00:01.19 | Mem:1M | Sample 1/8 | Error 3 %",
            "Sample 1/8 | Error 3 %",
        ),
        ("Sample 1/8", "Sample 1/8"),
    ],
)  # fmt: skip
def test_blenders_own_part_of_the_statistics_is_left_out(text: str, shown: str) -> None:
    assert summary.engine_text(text) == shown


def test_rays_are_counted_in_three_digits() -> None:
    assert [summary.count(v) for v in (0, 812, 3204, 14.5e6, 2e9)] == [
        "0",
        "812",
        "3.2 k",
        "14.5 M",
        "2 G",
    ]
