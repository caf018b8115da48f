"""Error against time on one scene: of Vernier's methods, and of Cycles, denoised and not.

Every render has a process of its own. Methods take turns, and times are processor time divided by
the threads: what else the machine does falls on all alike, and hardly counts.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vernier_tools import command_lines, images, jobs, references, tradeoff_page
from vernier_tools.errors import ToolError, blend_file_there, ended, say
from vernier_tools.images import FloatImage

COMMAND = "scripts/tradeoff"
#: Errors to which the time is told.
TARGETS = (0.10, 0.05, 0.02, 0.01)
#: A picture's error is that of all but this share of its pixels (engine_core/accuracy/statement.h).
PERCENTILE, FLOOR = 95.0, 0.01


@dataclass(frozen=True)
class Point:
    """One render. `error` is the root of the relative squared error, `percentile` the error that 95
    in 100 pixels do not exceed, `bias` the relative error of the mean."""

    engine: str
    budget: float
    seed: int
    seconds: float
    samples: float
    error: float
    percentile: float
    bias: float
    flip: float
    memory: int


@dataclass(frozen=True)
class Line:
    """Error = exp(offset) * seconds ** slope, fitted to a method's points."""

    slope: float
    offset: float

    def seconds_to(self, error: float) -> float:
        """Infinite where the error does not fall."""
        if self.slope >= 0:
            return math.inf
        power = (math.log(error) - self.offset) / self.slope
        return math.exp(power) if power < 700 else math.inf


def fit(points: Sequence[Point]) -> Line:
    """By least squares of the logarithms; with one budget, of the slope of independent samples."""
    x = np.log([point.seconds for point in points])
    y = np.log([max(point.error, 1e-12) for point in points])
    if len({point.budget for point in points}) < 2:
        return Line(-0.5, float(y.mean() + 0.5 * x.mean()))
    slope, offset = np.polyfit(x, y, 1)
    return Line(float(slope), float(offset))


def picture_error(image: FloatImage, reference: FloatImage) -> float:
    truth = images.luminance(reference).astype(np.float64)
    scale = np.maximum(truth, FLOOR * truth.mean())
    return float(np.percentile(abs(images.luminance(image) - truth) / scale, PERCENTILE))


def flip_of(image: FloatImage, reference: FloatImage) -> float:
    import flip_evaluator

    return float(flip_evaluator.evaluate(reference, image, "HDR", applyMagma=False)[1])


def point_of(
    job: jobs.Job, outcome: jobs.Outcome, picture: FloatImage, reference: references.Reference
) -> Point:
    render = outcome.renders[0]
    mean = float(reference.image.mean(dtype=np.float64))
    return Point(
        engine=job.engine,
        budget=job.time,
        seed=render.seed,
        seconds=render.cpu / (job.threads or os.cpu_count() or 1),
        samples=render.samples,
        error=math.sqrt(max(reference.error_of(picture), 0.0)),
        percentile=picture_error(picture, reference.image),
        bias=float(picture.mean(dtype=np.float64)) / mean - 1.0 if mean else math.nan,
        flip=flip_of(picture, reference.image),
        memory=render.peak_memory,
    )


def measure(options: argparse.Namespace, folder: Path) -> dict[str, Any]:
    """All renders; each method's longest stays in `folder` as it is viewed. Raises ToolError."""
    base = jobs.Job(
        engine="",
        blend=str(options.scene),
        output="",
        threads=options.threads,
        resolution=options.resolution,
    )
    say(COMMAND, "reference")
    reference = references.make(base, options.references, options.reference_time, options.cache)
    points: list[Point] = []
    failures: list[str] = []
    with tempfile.TemporaryDirectory() as temporary:
        for budget in sorted(options.budgets):
            for seed in range(1, options.repeats + 1):
                for engine in options.engines:
                    say(
                        COMMAND,
                        f"{jobs.ENGINES[engine]}, {budget:g} s, {seed} of {options.repeats}",
                    )
                    stem = str(Path(temporary, engine))
                    job = replace(
                        base, engine=engine, seeds=(seed,), time=budget, output=stem, view=True
                    )
                    try:
                        outcome = jobs.run(job)
                    except ToolError as error:
                        failures.append(str(error))
                        continue
                    picture = images.read_combined(Path(f"{stem}-{seed}.exr"))
                    points.append(point_of(job, outcome, picture, reference))
                    Path(f"{stem}-{seed}.png").replace(folder / f"{engine}.png")
    noise = math.sqrt(max(reference.noise, 0.0))
    return {
        "scene": options.scene.stem,
        "reference_error": noise,
        "references": list(options.references),
        "threads": options.threads or os.cpu_count() or 1,
        "engines": {
            engine: summary([point for point in points if point.engine == engine])
            for engine in options.engines
            if any(point.engine == engine for point in points)
        },
        "points": [asdict(point) for point in points],
        "failures": failures,
    }


def summary(points: Sequence[Point]) -> dict[str, Any]:
    line = fit(points)
    last = max(point.budget for point in points)
    longest = [point for point in points if point.budget == last]
    return {
        "slope": line.slope,
        "offset": line.offset,
        "seconds_to": {f"{100 * target:g} %": line.seconds_to(target) for target in TARGETS},
        "measured_to": max(point.seconds for point in points),
        "error": float(np.sqrt(np.mean([point.error**2 for point in longest]))),
        "percentile": float(np.mean([point.percentile for point in longest])),
        "bias": float(np.mean([point.bias for point in points])),
        "bias_error": float(
            np.std([point.bias for point in points], ddof=1) / math.sqrt(len(points))
            if len(points) > 1
            else math.nan
        ),
        "flip": float(np.mean([point.flip for point in longest])),
        "samples": float(np.mean([point.samples for point in longest])),
        "memory": max(point.memory for point in points),
    }


def work(options: argparse.Namespace) -> int:
    output: Path = options.output or Path("out", "tradeoff", options.scene.stem)
    blend_file_there(options.scene)
    output.mkdir(parents=True, exist_ok=True)
    figures = measure(options, output)
    (output / "figures.json").write_text(json.dumps(figures, indent=1) + "\n")
    tradeoff_page.write_page(output / "index.html", figures)
    print(tradeoff_page.markdown(figures), end="")
    return 1 if figures["failures"] else 0


def main() -> int:
    options = command_lines.tradeoff(sys.argv[1:])
    return ended(COMMAND, lambda: work(options))


if __name__ == "__main__":
    sys.exit(main())
