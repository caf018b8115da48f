"""The measured trade: its fit, its table, and a short run."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from tool_process import CORNELL_BOX, Tool
from vernier_tools import tradeoff, tradeoff_page


def points(slope: float, at_one: float) -> list[tradeoff.Point]:
    return [
        tradeoff.Point(
            "vernier", t, seed, t, 4 * t, at_one * t**slope, at_one, 1e-3 * seed, 0.1, 2**20
        )
        for t in (1.0, 2.0, 8.0)
        for seed in (1, 2)
    ]


def test_a_line_tells_the_time_to_an_error() -> None:
    line = tradeoff.fit(points(-0.5, 0.2))
    assert line.slope == pytest.approx(-0.5)
    assert line.seconds_to(0.1) == pytest.approx(4.0)
    assert math.isinf(tradeoff.fit(points(0.0, 0.2)).seconds_to(0.1))
    single = tradeoff.fit([p for p in points(-0.5, 0.2) if p.budget == 2.0])
    assert single.seconds_to(0.1) == pytest.approx(4.0)


def test_the_table_marks_what_was_not_measured() -> None:
    figures = {
        "scene": "box",
        "reference_error": 0.001,
        "engines": {"vernier": tradeoff.summary(points(-0.5, 0.2))},
        "points": [],
        "failures": ["it rained"],
    }
    text = tradeoff_page.markdown(figures)
    assert "| Vernier | -0.50 | 4 | (16) | (100) | (400) | 7.1 % |" in text
    assert "it rained" in text
    figures["engines"] = {"vernier": tradeoff.summary(points(0.0, 12.0)[:1])}
    text = tradeoff_page.markdown(figures)
    assert "| 1200 % | 1200 % | +0.10 % |" in text
    assert "nan" not in text


def test_errors_of_pictures() -> None:
    reference = np.full((10, 10, 3), 2.0, np.float32)
    image = reference.copy()
    assert tradeoff.picture_error(image, reference) == 0.0
    image[:, :3] *= 1.5
    assert tradeoff.picture_error(image, reference) == pytest.approx(0.5, rel=1e-5)


def test_a_short_run_makes_the_page(tool: Tool, tmp_path: Path) -> None:
    done = tool(
        "tradeoff",
        str(CORNELL_BOX),
        *("--engines", "vernier,cycles", "--budgets", "1,3", "--repeats", "1"),
        *("--reference-time", "6", "--resolution", "32x32", "--cache", str(tmp_path / "cache")),
        *("-o", str(tmp_path / "page")),
    )
    assert done.returncode == 0, done.stderr
    assert "**cornell_box**" in done.stdout
    figures = json.loads((tmp_path / "page" / "figures.json").read_text())
    assert len(figures["points"]) == 4
    assert figures["engines"]["vernier"]["memory"] > 0
    assert "<svg" in (tmp_path / "page" / "index.html").read_text()
    assert (tmp_path / "page" / "cycles.png").stat().st_size > 0
