"""Rendering in processes of their own, and the comparison's page, with Cycles as both sides."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest
from tool_process import CORNELL_BOX, Tool
from vernier_tools import comparison_page, images, jobs
from vernier_tools.errors import ToolError

SMALL = jobs.Job(
    engine="cycles", blend=str(CORNELL_BOX), output="", samples=2, resolution=(24, 16), threads=2
)


def test_a_job_renders_each_seed_and_measures(tmp_path: Path) -> None:
    job = dataclasses.replace(SMALL, output=str(tmp_path / "a"), seeds=(3, 4), view=True)
    outcome = jobs.run(job)
    assert (outcome.engine, outcome.width, outcome.height) == ("cycles", 24, 16)
    assert outcome.triangles > 10
    assert [render.seed for render in outcome.renders] == [3, 4]
    for render in outcome.renders:
        assert render.samples == 2
        assert 0 < render.first_sample <= render.first_tile <= render.seconds
        assert render.peak_memory > render.memory >= 0
    first, second = (images.read_combined(tmp_path / f"a-{seed}.exr") for seed in (3, 4))
    assert first.shape == (16, 24, 3)
    assert np.isfinite(first).all()
    assert not np.array_equal(first, second)
    view = images.read_combined(tmp_path / "a-3.png")
    assert view.shape == (16, 24, 3)
    assert np.max(view) <= 1


def test_equal_seeds_give_equal_pictures(tmp_path: Path) -> None:
    for name in ("a", "b"):
        jobs.run(dataclasses.replace(SMALL, output=str(tmp_path / name)))
    first, second = (images.read_combined(tmp_path / f"{name}-0.exr") for name in ("a", "b"))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("instanced", [False, True])
def test_generated_scenes_have_the_triangles_asked_for(instanced: bool) -> None:
    made = jobs.GeneratedScene(triangles=40_000, instanced=instanced)
    outcome = jobs.run(dataclasses.replace(SMALL, blend="", samples=1, generated=made))
    assert outcome.triangles == pytest.approx(40_000, rel=0.02)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"blend": "/nowhere/a.blend"}, "No such file"),
        ({"settings": {"nonsense": 1}}, "no setting named nonsense"),
    ],
)
def test_a_job_that_fails_says_why(change: dict[str, object], message: str) -> None:
    with pytest.raises(ToolError, match=message):
        jobs.run(dataclasses.replace(SMALL, **change))  # type: ignore[arg-type]


def test_jobs_and_outcomes_survive_json() -> None:
    job = dataclasses.replace(SMALL, seeds=(1, 2), generated=jobs.GeneratedScene(5, True))
    assert jobs.job_from_json(json.loads(json.dumps(dataclasses.asdict(job)))) == job
    render = jobs.Render(1, 2.0, 3.0, 2.5, 0.1, 0.2, 1.8, 16.0, 5, 6, 7)
    outcome = jobs.Outcome("cycles", "5", 8, 9, 10, (render,), ("a",))
    assert jobs.outcome_from_json(json.loads(json.dumps(dataclasses.asdict(outcome)))) == outcome


def test_cycles_agrees_with_itself(tool: Tool, tmp_path: Path) -> None:
    done = tool(
        "compare", CORNELL_BOX, "--engines", "cycles,cycles", "--samples", 32, "-o", "page",
        "--resolution", "48x48",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "page"
    figures = json.loads((folder / "figures.json").read_text())
    assert abs(figures["mean_ratio"] - 1) < 5 * figures["mean_ratio_error"]
    assert figures["worst_block_probability"] > 1e-5
    # What the pictures differ by is the noise of both; a few dark pixels carry most of either.
    noise = sum(figures["relative_squared_noise"])
    assert noise / 4 < figures["relative_squared_difference"] < noise * 4
    page = (folder / "index.html").read_text()
    pictures = set(re.findall(r'src="([^"]+)"', page))
    assert len(pictures) == 5
    for picture in pictures:
        assert images.read_combined(folder / picture).shape == (48, 48, 3)


def test_the_page_escapes_what_comes_from_files(tmp_path: Path) -> None:
    render = jobs.Render(1, 2.0, 3.0, 2.5, 0.1, 0.2, 1.8, 16.0, 5, 6, 7)
    outcome = jobs.Outcome("vernier", "5", 8, 9, 10, (render,), ("<script>",))
    figures = {
        "engines": ["Vernier", "Cycles"],
        "mean_ratio": 1.0,
        "mean_ratio_error": 0.1,
        "relative_squared_difference": 0.1,
        "relative_squared_noise": [0.1, 0.1],
        "worst_block_z": 1.0,
        "worst_block_probability": 0.5,
        "block": 16,
        "flip_mean": 0.1,
        "not_finite": [0, 0],
        "outcomes": [dataclasses.asdict(outcome)] * 2,
    }
    comparison_page.write_page(tmp_path / "index.html", "a & b", figures)
    page = (tmp_path / "index.html").read_text()
    assert "a &amp; b" in page
    assert "&lt;script&gt;" in page
    assert "<script>" not in page


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere.blend"], "nowhere.blend: no such file"),
        (["a.blend", "--samples", "0"], "not a positive whole number"),
        (["a.blend", "--engines", "cycles"], "--engines takes two"),
    ],
)
def test_bad_calls_are_one_line(tool: Tool, arguments: list[str], message: str) -> None:
    done = tool("compare", *arguments)
    assert done.returncode != 0
    assert done.stderr.startswith("scripts/compare_cycles: error: ")
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1
