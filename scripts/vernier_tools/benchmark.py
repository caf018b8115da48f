"""Measures Vernier beside Cycles: speed, error at equal time, preparation, memory.

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

from vernier_tools import benchmark_tables, images, jobs, metrics, references
from vernier_tools.arguments import Parser, positive_float, positive_int, resolution
from vernier_tools.errors import ToolError, report

COMMAND = "scripts/benchmark"
ROOT = Path(__file__).parents[2]
PARTS = ("scenes", "sizes")

MEDIANS = (
    "samples_per_second",
    "rays_per_second",
    "first_sample",
    "first_tile",
    "memory",
    "peak_memory",
)

Figures = dict[str, Any]


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = Parser(prog=COMMAND, description=__doc__)
    parser.add_argument(
        "scenes", nargs="*", type=Path, metavar="SCENE.blend", help="default: all of blend_scenes"
    )
    parser.add_argument("--time", type=positive_float, default=8.0, help="seconds a render (8)")
    parser.add_argument("--repeats", type=positive_int, default=3, help="renders an engine (3)")
    parser.add_argument(
        "--reference-time", type=positive_float, default=120.0, help="seconds a reference (120)"
    )
    parser.add_argument(
        "--references",
        default="vernier,cycles",
        help="the engines whose long renders make the reference (%(default)s)",
    )
    parser.add_argument("--engines", default="vernier,cycles", help="default: %(default)s")
    parser.add_argument("--parts", default=",".join(PARTS), help="default: %(default)s")
    parser.add_argument(
        "--triangles", default="1,4,16", help="sizes of the generated scenes, in millions"
    )
    parser.add_argument("--threads", type=positive_int, default=0, help="default: all")
    parser.add_argument("--resolution", type=resolution, default=(0, 0), metavar="WxH")
    parser.add_argument("--cache", type=Path, default=references.default_cache())
    parser.add_argument("-o", "--output", type=Path, default=Path("out", "benchmark"))
    options = parser.parse_args(arguments)
    for name, known in (("engines", jobs.ENGINES), ("references", jobs.ENGINES), ("parts", PARTS)):
        chosen = tuple(getattr(options, name).split(","))
        if not set(chosen) <= set(known):
            parser.error(f"--{name}: choose from {', '.join(known)}")
        setattr(options, name, chosen)
    try:
        options.triangles = [float(text) * 1e6 for text in options.triangles.split(",")]
    except ValueError:
        parser.error("--triangles takes numbers separated by commas")
    options.scenes = options.scenes or sorted((ROOT / "blend_scenes").glob("*.blend"))
    return options


def say(text: str) -> None:
    print(f"{COMMAND}: {text}", file=sys.stderr, flush=True)


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
    say(f"{scene.stem}: reference")
    reference = references.make(base, options.references, options.reference_time, options.cache)
    runs: dict[str, list[Figures]] = {engine: [] for engine in options.engines}
    outcome: jobs.Outcome | None = None
    with tempfile.TemporaryDirectory() as folder:
        for repeat in range(options.repeats):
            for engine in options.engines:
                say(f"{scene.stem}: {jobs.ENGINES[engine]}, {repeat + 1} of {options.repeats}")
                output = str(Path(folder, engine))
                job = replace(base, engine=engine, seeds=(repeat + 1,), output=output)
                outcome = jobs.run(job)
                picture = images.read_combined(Path(f"{job.output}-{repeat + 1}.exr"))
                error = reference.error_of(picture)
                runs[engine].append(run_figures(outcome, error, options.time))
    assert outcome is not None
    figures: Figures = {
        "scene": scene.stem,
        "width": outcome.width,
        "height": outcome.height,
        "triangles": outcome.triangles,
        "reference_noise": reference.noise,
        "engines": {engine: summarize(items) for engine, items in runs.items()},
    }
    if set(reference.halves) == {"vernier", "cycles"}:
        agree = metrics.agreement(reference.halves["vernier"], reference.halves["cycles"])
        figures["mean_ratio"] = agree.ratio
        figures["mean_ratio_error"] = agree.ratio_error
        figures["worst_block_z"] = agree.worst_z
    return figures


def run_figures(outcome: jobs.Outcome, error: float, time: float) -> Figures:
    render = outcome.renders[0]
    return {
        **asdict(render),
        "samples_per_second": render.samples_per_second(outcome.width * outcome.height),
        "rays_per_second": render.rays / render.sampling,
        # No engine ends a render at exactly the time asked for. Error falls as one over time, so
        # this is what it would be there.
        "error": error * render.seconds / time,
        "warnings": list(outcome.warnings),
    }


def summarize(runs: list[Figures]) -> Figures:
    """An engine's runs on one scene in short, and the runs themselves.

    Medians, but for the error: a few bright pixels carry much of it, and only the mean over runs
    does not hide them.
    """
    figures: Figures = {name: statistics.median(run[name] for run in runs) for name in MEDIANS}
    return {**figures, "error": statistics.fmean(run["error"] for run in runs), "runs": runs}


def measure_size(options: argparse.Namespace, triangles: float, instanced: bool) -> Figures:
    """Preparation and memory of each engine on one generated scene: medians over the repeats."""
    spec = jobs.GeneratedScene(round(triangles), instanced)
    kind = "instanced" if instanced else "flat"
    runs: dict[str, list[Figures]] = {engine: [] for engine in options.engines}
    count = 0
    for repeat in range(options.repeats):
        for engine in options.engines:
            name = jobs.ENGINES[engine]
            say(f"{triangles / 1e6:g} million triangles, {kind}: {name}, {repeat + 1}")
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
            runs[engine].append(run_figures(outcome, 0.0, 1.0))
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
        say(f"{name}: {error}")
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
        "sizes": [],
        "failures": [],
    }
    failures = results["failures"]
    if "scenes" in options.parts:
        for scene in options.scenes:
            results["scenes"] += attempt(
                scene.stem, partial(measure_scene, options, scene), failures
            )
            write(results, options.output)
    if "sizes" in options.parts:
        for triangles in options.triangles:
            for instanced in (False, True):
                results["sizes"] += attempt(
                    f"{triangles:g} triangles",
                    partial(measure_size, options, triangles, instanced),
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


def main() -> int:
    options = parse(sys.argv[1:])
    try:
        for scene in options.scenes:
            if not scene.is_file():
                raise ToolError(f"{scene}: no such file")
        options.output.mkdir(parents=True, exist_ok=True)
        results = benchmark(options)
        write(results, options.output)
    except (ToolError, OSError) as error:
        report(COMMAND, error)
        return 1
    except KeyboardInterrupt:
        return 130
    print(benchmark_tables.markdown(results), end="")
    return 1 if results["failures"] else 0


if __name__ == "__main__":
    sys.exit(main())
