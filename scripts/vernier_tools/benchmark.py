"""Measures Vernier beside Cycles: speed, error at equal time, rays, preparation, memory.

Each render has a process of its own, and the engines take turns, so that what else the machine does
falls on both alike.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

from vernier_tools import benchmark_tables, command_lines, images, jobs, metrics, references
from vernier_tools.errors import ToolError, blend_file_there, ended, say

COMMAND = "scripts/benchmark"
MEDIANS = (
    "samples_per_cpu_second",
    "preparation",
    "first_sample",
    "first_tile",
    "memory",
    "peak_memory",
)

Figures = dict[str, Any]


def scene_job(options: argparse.Namespace, scene: Path) -> jobs.Job:
    return jobs.Job(
        engine="",
        blend=str(scene),
        output="",
        threads=options.threads,
        resolution=options.resolution,
        time=options.time,
    )


def measure_scene(options: argparse.Namespace, scene: Path) -> Figures:
    """Speed and error of each engine on one scene. Raises ToolError."""
    base = scene_job(options, scene)
    say(COMMAND, f"{scene.stem}: reference")
    reference = references.make(base, options.references, options.reference_time, options.cache)
    runs: dict[str, list[Figures]] = {engine: [] for engine in options.engines}
    outcome: jobs.Outcome | None = None
    with tempfile.TemporaryDirectory() as folder:
        for repeat in range(options.repeats):
            for engine in options.engines:
                say(
                    COMMAND,
                    f"{scene.stem}: {jobs.ENGINES[engine]}, {repeat + 1} of {options.repeats}",
                )
                output = str(Path(folder, engine))
                job = replace(base, engine=engine, seeds=(repeat + 1,), output=output)
                outcome = jobs.run(job)
                picture = images.read_combined(Path(f"{job.output}-{repeat + 1}.exr"))
                error = reference.error_of(picture)
                figures = run_figures(outcome, error, cpu_budget(options))
                figures["worst_share"] = metrics.share_of_the_worst(picture, reference.image)
                runs[engine].append(figures)
    assert outcome is not None
    result: Figures = {
        "scene": scene.stem,
        "width": outcome.width,
        "height": outcome.height,
        "triangles": outcome.triangles,
        "reference_noise": reference.noise,
        "engines": {engine: summarize(items) for engine, items in runs.items()},
    }
    if set(reference.halves) == {"vernier", "cycles"}:
        agree = metrics.agreement(reference.halves["vernier"], reference.halves["cycles"])
        result["mean_ratio"] = agree.ratio
        result["mean_ratio_error"] = agree.ratio_error
        result["worst_block_z"] = agree.worst_z
    return result


def cpu_budget(options: argparse.Namespace) -> float:
    """The processor time that a render may use, in seconds."""
    return float(options.time * (options.threads or os.cpu_count() or 1))


def run_figures(outcome: jobs.Outcome, error: float, budget: float) -> Figures:
    render = outcome.renders[0]
    return {
        **asdict(render),
        "preparation": render.cpu - render.sampling_cpu,
        "samples_per_cpu_second": render.samples_per_cpu_second(outcome.width * outcome.height),
        # No engine ends a render at exactly the time asked for, nor has it the machine for itself.
        # Error falls as one over the time spent, so this is what it would be at that asked for.
        "error": error * render.cpu / budget,
        "warnings": list(outcome.warnings),
    }


def summarize(runs: list[Figures]) -> Figures:
    """An engine's runs on one scene in short, and the runs themselves.

    Medians, but for the error: a few bright pixels carry much of it, and only the mean over runs
    does not hide them.
    """
    figures: Figures = {name: statistics.median(run[name] for run in runs) for name in MEDIANS}
    return {**figures, "error": statistics.fmean(run["error"] for run in runs), "runs": runs}


def measure_rays(options: argparse.Namespace, scene: Path) -> Figures:
    """Vernier's rate of rays beside Embree's. Raises ToolError."""
    say(COMMAND, f"{scene.stem}: rays")
    job = replace(scene_job(options, scene), engine="vernier", time=0.0, samples=1)
    rate = jobs.run_ray_rate(job)
    return {"scene": scene.stem, **asdict(rate)}


def measure_photons(options: argparse.Namespace, scene: Path) -> Figures:
    """What a million photons cost beside a million camera paths. Raises ToolError."""
    say(COMMAND, f"{scene.stem}: photons")
    job = replace(
        scene_job(options, scene),
        engine="vernier",
        time=0.0,
        samples=1,
        photons=round(options.photons * 1e6),
    )
    return {"scene": scene.stem, **asdict(jobs.run_photon_rate(job))}


def measure_size(options: argparse.Namespace, triangles: float, instanced: bool) -> Figures:
    """Preparation and memory of each engine on one generated scene: medians over the repeats."""
    spec = jobs.GeneratedScene(round(triangles), instanced)
    kind = "instanced" if instanced else "flat"
    runs: dict[str, list[Figures]] = {engine: [] for engine in options.engines}
    count = 0
    for repeat in range(options.repeats):
        for engine in options.engines:
            name = jobs.ENGINES[engine]
            say(COMMAND, f"{triangles / 1e6:g} million triangles, {kind}: {name}, {repeat + 1}")
            job = jobs.Job(
                engine=engine,
                blend="",
                output="",
                samples=1,
                threads=options.threads,
                generated=spec,
            )
            outcome = jobs.run(job)
            count = outcome.triangles
            runs[engine].append(run_figures(outcome, 0.0, cpu_budget(options)))
    return {
        "triangles": count,
        "instanced": instanced,
        "engines": {engine: summarize(items) for engine, items in runs.items()},
    }


def attempt(name: str, measure: Callable[[], Figures], failures: list[str]) -> list[Figures]:
    """The figures in a list, or nothing and a line in `failures`: one scene must not end all."""
    try:
        return [measure()]
    except ToolError as error:
        say(COMMAND, f"{name}: {error}")
        failures.append(f"{name}: {error}")
        return []


def benchmark(options: argparse.Namespace) -> Figures:
    """All measurements, in one dictionary that JSON can hold; written anew after each one."""
    results: Figures = {
        "machine": f"{processor_name()}, {os.cpu_count()} threads",
        "system": platform.platform(),
        "seconds": options.time,
        "repeats": options.repeats,
        "reference_seconds": options.reference_time,
        "scenes": [],
        "rays": [],
        "photons": [],
        "sizes": [],
        "failures": [],
    }
    failures = results["failures"]
    by_scene = {"scenes": measure_scene, "rays": measure_rays, "photons": measure_photons}
    for part, measure in by_scene.items():
        for scene in options.scenes if part in options.parts else ():
            results[part] += attempt(scene.stem, partial(measure, options, scene), failures)
            write(results, options.output)
    if "sizes" in options.parts:
        for triangles in options.triangles:
            for instanced in (False, True):
                results["sizes"] += attempt(
                    f"{triangles:g} million triangles",
                    partial(measure_size, options, triangles * 1e6, instanced),
                    failures,
                )
                write(results, options.output)
    return results


def processor_name() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def write(results: Figures, folder: Path) -> None:
    (folder / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    (folder / "results.md").write_text(benchmark_tables.markdown(results))


def work(options: argparse.Namespace) -> int:
    for scene in options.scenes:
        blend_file_there(scene)
    options.output.mkdir(parents=True, exist_ok=True)
    results = benchmark(options)
    write(results, options.output)
    print(benchmark_tables.markdown(results), end="")
    return 1 if results["failures"] else 0


def main() -> int:
    options = command_lines.benchmark(sys.argv[1:])
    return ended(COMMAND, lambda: work(options))


if __name__ == "__main__":
    sys.exit(main())
