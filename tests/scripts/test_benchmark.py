"""The benchmark: its measures, its tables, and a short run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from tool_process import Tool
from vernier_tools import benchmark_tables, jobs, references


def entry(engines: list[str], worst_share: float = 0.1) -> dict[str, object]:
    figures = {
        name: {
            "samples_per_cpu_second": 2e6 / (index + 1),
            "error": 0.01 * (index + 1),
            "preparation": 0.25,
            "first_sample": 0.5,
            "first_tile": 1.0,
            "memory": 2**20 * 8,
            "peak_memory": 2**20 * 300,
            "runs": [{"worst_share": worst_share}],
        }
        for index, name in enumerate(engines)
    }
    return {
        "scene": "box",
        "triangles": 1234,
        "width": 8,
        "height": 6,
        "reference_noise": 0.001,
        "instanced": True,
        "engines": figures,
    }


def results(engines: list[str]) -> dict[str, object]:
    return {
        "machine": "machine",
        "seconds": 8,
        "repeats": 3,
        "reference_seconds": 60,
        "scenes": [entry(engines)],
        "rays": [{"scene": "box", "rays": 7, "rendered": 3e6, "bare": 4e6}],
        "photons": [
            {
                "scene": "box",
                "photons": 1_000_123,
                "paths": 300_000,
                "bytes_of_photon": 40.6,
                "map_seconds": 0.8,
                "camera_seconds": 1.6,
                "query_seconds": 9e-6,
                "scipy_seconds": 3e-5,
            }
        ],
        "sizes": [entry(engines)],
        "failures": ["pool: it rained"],
    }


def test_tables_show_ratios_of_vernier_over_cycles() -> None:
    text = benchmark_tables.markdown(results(["vernier", "cycles"]))
    assert "| box | 1,234 | 8x6 | 2.000 | 1.000 | 2.00 | 0.01 | 0.02 | 0.50 |" in text
    assert "| box | 3.00 | 4.00 | 0.75 |" in text
    assert "| box | 1,000,123 | 41 | 0.80 | 1.60 | 9.0 | 30.0 |" in text
    assert "pool: it rained" in text
    for block in text.split("\n\n"):
        if block.startswith("|"):
            widths = {line.count("|") for line in block.strip().splitlines()}
            assert len(widths) == 1


def test_errors_of_few_pixels_are_in_parentheses() -> None:
    figures = results(["vernier", "cycles"])
    figures["scenes"] = [entry(["vernier", "cycles"], worst_share=0.6)]
    assert "| (0.01) | (0.02) | (0.50) |" in benchmark_tables.markdown(figures)


def test_tables_of_one_engine_have_no_ratios() -> None:
    text = benchmark_tables.markdown(results(["cycles"]))
    assert " ratio |" not in text.split("## Rays")[0].replace("mean ratio |", "")
    assert "| box | 1,234 | 8x6 | 2.000 | 0.01 | 1.00 | 8 |" in text


def test_the_noise_of_a_reference_is_known_and_taken_off(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    rng = np.random.default_rng(1)
    truth = rng.uniform(0.5, 2.0, (64, 64, 3)).astype(np.float32)

    def render(sigma: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
        return (truth + rng.normal(0, sigma, truth.shape)).astype(np.float32)

    def long_render(*_: object) -> object:
        return render(0.1), render(0.1)

    monkeypatch.setattr(references, "long_render", long_render)
    job = jobs.Job(engine="", blend="", output="")
    reference = references.make(job, ["vernier", "cycles"], 1.0, tmp_path)
    weight = float(np.mean(1 / (truth**2 + 0.01 * np.mean(truth) ** 2)))
    # Four independent pictures of variance 0.01 are averaged.
    assert reference.noise == pytest.approx(0.1**2 / 4 * weight, rel=0.1)
    error = reference.error_of(render(0.3))
    assert error == pytest.approx(0.3**2 * weight, rel=0.1)


def test_a_short_run_writes_its_results_and_keeps_references(tool: Tool, tmp_path: Path) -> None:
    arguments = [
        "--scenes", "cornell_box", "--references", "cycles", "--time", 0.3, "--reference-time", 1,
        "--repeats", 1, "--triangles", 0.01, "--resolution", "24x16", "--cache", "cache",
        "-o", "results",
    ]  # fmt: skip
    done = tool("benchmark", *arguments)
    assert done.returncode == 0, done.stderr
    figures = json.loads((tmp_path / "results" / "results.json").read_text())
    for engine in ("vernier", "cycles"):
        measured = figures["scenes"][0]["engines"][engine]
        assert measured["samples_per_cpu_second"] > 0
        assert 0 < measured["error"] < 100
        assert 0 < measured["first_sample"] <= measured["first_tile"]
    rays = figures["rays"][0]
    assert rays["rays"] > 1e6
    assert 0 < rays["rendered"] < rays["bare"]
    assert [size["instanced"] for size in figures["sizes"]] == [False, True]
    assert done.stdout == (tmp_path / "results" / "results.md").read_text()

    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / "cache").iterdir()}
    assert len(kept) == 2
    again = tool("benchmark", *arguments, "--parts", "scenes", "--engines", "cycles")
    assert again.returncode == 0, again.stderr
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "cache").iterdir()} == kept


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--scenes", "nowhere"], "nowhere: no such file"),
        (["--parts", "all"], "--parts: 'all': choose from scenes, rays, photons, sizes"),
        (["--triangles", "many"], "--triangles: 'many' is not a positive number"),
    ],
)
def test_bad_calls_are_one_line(tool: Tool, arguments: list[str], message: str) -> None:
    done = tool("benchmark", *arguments)
    assert done.returncode != 0
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1
