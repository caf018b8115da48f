"""Whether Auto chooses well, and whether adaptive sampling pays.

Methods render each small picture at equal processor time, several times, beside a long render.
The deviation of the pixels' values falls with the root of the time, so its square compares the
times that methods need to any error. Auto chooses for a larger picture of the same scene, as users
render: its trial has few pixels in a small one.
"""

from __future__ import annotations

import argparse
import copy
import json
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vernier_tools import accuracy_lines, calibration, core_renders
from vernier_tools.core_renders import CoreRender
from vernier_tools.describe import described, sized
from vernier_tools.errors import ToolError, blend_file_there, ended, say
from vernier_tools.variations import variations

if TYPE_CHECKING:
    from engine_core.description import SceneDescription

COMMAND = "scripts/methods"
REFERENCE_SEED = 1_000_001
#: The error to which times are told.
ERROR = 0.05
#: Samples that tell what one costs, and the least of renders that are compared.
TRIED = 32
#: Samples of the render that Auto chooses for: its pilot is a twentieth of these.
CHOSEN_FOR = 4096


@dataclass(frozen=True)
class Row:
    """One scene. `seconds` of processor time to an error of 5 %, by method, and how uncertain that
    is: their relative standard errors. `usual` seconds are by the error that 95 in 100 renders of
    the time that was measured do not exceed: rare bright pixels count by how many there are."""

    scene: str
    seconds: dict[str, float]
    uncertain: dict[str, float]
    usual: dict[str, float]
    chosen: str
    reason: str

    def times_best(self, seconds: dict[str, float]) -> float:
        """How much longer the chosen method takes than the best."""
        best = min(seconds.values())
        return seconds.get(self.chosen, math.nan) / best if best > 0.0 else math.nan


@dataclass(frozen=True)
class Adaptive:
    """Processor time to one target, with adaptive sampling and without."""

    scene: str
    target: float
    seconds: float
    uniform_seconds: float
    error: float
    uniform_error: float

    @property
    def ratio(self) -> float:
        return self.seconds / self.uniform_seconds


@dataclass(frozen=True)
class Measured:
    """What one method did: renders of equal time, and the processor seconds that it takes before
    its first sample, which are the same in longer ones."""

    runs: Sequence[CoreRender]
    preparation: float

    def seconds_to(self, error: float, reached: float) -> float:
        """Where renders of this time reach an error, which falls with the root of it."""
        sampling = float(np.mean([run.seconds for run in self.runs])) - self.preparation
        return self.preparation + max(sampling, 0.0) * (reached / error) ** 2

    def values(self) -> calibration.Array:
        return np.array([run.values for run in self.runs])


def seconds_to(error: float, measured: Measured, reference: CoreRender) -> float:
    """By the runs' true deviations."""
    reached = calibration.deviation(measured.values(), reference.values, reference.halves)
    return measured.seconds_to(error, calibration.NORMAL_QUANTILE * reached)


def usual_seconds_to(error: float, measured: Measured, reference: CoreRender) -> float:
    """By the runs' errors as a picture's error is defined, as if they fell with the root of the
    time. Infinite where light that all runs lack is more than that error: it does not fall so."""
    lacking = calibration.lacking(measured.values(), reference.values, reference.halves)
    if np.quantile(lacking, calibration.PERCENTILE) > error:
        return math.inf
    reached = calibration.usual_error(measured.values(), reference.values, reference.halves)
    return measured.seconds_to(error, reached)


def uncertainty(measured: Measured, reference: CoreRender) -> float:
    """Of seconds_to(), relative: by leaving out one run after the other (the jackknife)."""
    runs = measured.runs
    count = len(runs)
    if count < 3:
        return math.nan
    parts = np.array([
        seconds_to(ERROR, replace(measured, runs=[*runs[:k], *runs[k + 1 :]]), reference)
        for k in range(count)
    ])  # fmt: skip
    mean = float(parts.mean())
    spread = math.sqrt((count - 1) * float(parts.var()))
    return spread / mean if mean > 0.0 else math.nan


def at_width(description: SceneDescription, width: int) -> SceneDescription:
    """The whole frame, `width` pixels wide."""
    return sized(replace(description, film=copy.copy(description.film)), width)


def choice(scene: Any, threads: int) -> tuple[str, str]:
    """What Auto chooses for a long render, and why. Raises ToolError."""
    import engine_core

    settings = {"integrator": "AUTO", "samples": CHOSEN_FOR, "threads": threads}
    session = engine_core.Session(scene, settings, ["Combined"])
    session.start()
    while not session.choice and not session.wait(0.02):
        pass
    session.cancel()
    while not session.wait(1.0):
        pass
    if session.error_message:
        raise ToolError(session.error_message)
    return session.integrator, session.choice


def samples_for(scene: Any, method: str, seconds: float, threads: int) -> tuple[int, float]:
    """How many take about this much processor time, and what comes before them, seconds.

    Limits are of the time that passes, and some methods look for light before they begin: so
    renders that are compared have a number of samples. Raises ToolError.
    """
    preparation, tried = (
        core_renders.rendered(scene, method, 0, threads=threads, samples=samples).seconds
        for samples in (1, TRIED)
    )
    sample = max(tried - preparation, 1e-6) / TRIED
    return max(round((seconds - preparation) / sample), TRIED), preparation


def measure(scene: Any, method: str, seconds: float, count: int, threads: int) -> Measured:
    """Raises ToolError."""
    samples, preparation = samples_for(scene, method, seconds, threads)
    runs = [
        core_renders.rendered(scene, method, seed, threads=threads, samples=samples)
        for seed in range(1, count + 1)
    ]
    return Measured(runs, preparation)


def long_render(scene: Any, method: str, seconds: float, threads: int) -> CoreRender:
    """Raises ToolError."""
    samples, _ = samples_for(scene, method, seconds, threads)
    return core_renders.rendered(scene, method, REFERENCE_SEED, threads=threads, samples=samples)


def method_row(name: str, description: SceneDescription, options: argparse.Namespace) -> Row:
    """Raises ToolError."""
    threads = options.threads
    large = core_renders.compiled(at_width(description, options.chosen_width))
    chosen, reason = choice(large, threads)
    scene = core_renders.compiled(at_width(description, options.width))
    measured = {
        method: measure(scene, method, options.seconds, options.runs, threads)
        for method in options.integrators
    }
    # Methods are of equal expectation, so several can make it, of which the better counts more. One
    # that misses light cannot tell, and must not be among them.
    references = options.references or options.integrators
    share = options.reference_time / len(references)
    long = [long_render(scene, method, share, threads) for method in references]
    reference = weighted(long)
    seconds = {method: seconds_to(ERROR, each, reference) for method, each in measured.items()}
    uncertain = {method: uncertainty(each, reference) for method, each in measured.items()}
    usual = {method: usual_seconds_to(ERROR, each, reference) for method, each in measured.items()}
    return Row(name, seconds, uncertain, usual, chosen, reason)


def weighted(renders: Sequence[CoreRender]) -> CoreRender:
    """Their mean by pictures' errors, and its half-widths. Raises ToolError where none is known."""
    renders = [render for render in renders if math.isfinite(render.error)]
    if not renders:
        raise ToolError("a reference of this time knows nothing")
    inverse = [1.0 / max(render.error, 1e-12) ** 2 for render in renders]
    weights = [each / sum(inverse) for each in inverse]
    values = sum(w * render.values for w, render in zip(weights, renders, strict=True))
    squares = sum((w * render.halves) ** 2 for w, render in zip(weights, renders, strict=True))
    best = min(renders, key=lambda render: render.error)
    return CoreRender(
        np.asarray(values), np.sqrt(np.asarray(squares)), best.error, best.samples, best.seconds,
        best.ending, best.integrator, best.choice,
    )  # fmt: skip


def adaptive_row(name: str, description: SceneDescription, options: argparse.Namespace) -> Adaptive:
    """Raises ToolError."""
    scene = core_renders.compiled(at_width(description, options.width))
    runs: dict[bool, list[CoreRender]] = {
        adaptive: [
            core_renders.rendered(
                scene, "PATH", seed, threads=options.threads, target_error=options.target,
                adaptive=adaptive, time_limit=options.reference_time,
            )
            for seed in range(1, options.runs + 1)
        ]
        for adaptive in (True, False)
    }  # fmt: skip
    late = [run for each in runs.values() for run in each if run.ending != "target"]
    if late:
        raise ToolError(f"{options.target:g} % are not reached in {options.reference_time:g} s")
    seconds, errors = (
        {key: float(np.mean([getattr(run, what) for run in each])) for key, each in runs.items()}
        for what in ("seconds", "error")
    )
    return Adaptive(
        name, options.target, seconds[True], seconds[False], errors[True], errors[False]
    )


def scenes(options: argparse.Namespace, path: Path) -> Iterator[tuple[str, SceneDescription]]:
    description = described(path)
    yield path.stem, description
    if options.variations:
        for what, changed in variations(description):
            yield f"{path.stem}, {what}", changed


def told(seconds: float) -> str:
    """Three digits, yet never an exponent; a dash for what is infinite."""
    if math.isinf(seconds):
        return "–"
    return f"{seconds:.3g}" if seconds < 999.5 else f"{seconds:.0f}"


def methods_table(rows: Sequence[Row]) -> str:
    names = list(rows[0].seconds) if rows else []
    head = [f"`{name.lower()}`, s" for name in names]
    lines = [f"| Scene | {' | '.join(head)} | Auto takes | times the best |"]
    lines.append("|---|" + "---:|" * len(names) + "---|---:|")
    for row in rows:
        cells = [
            f"{told(row.seconds[name])} ± {100 * row.uncertain[name]:.0f} % "
            f"/ {told(row.usual[name])}"
            for name in names
        ]
        ratios = f"{row.times_best(row.seconds):.2f} / {row.times_best(row.usual):.2f}"
        lines.append(f"| `{row.scene}` | {' | '.join(cells)} | `{row.chosen.lower()}` | {ratios} |")
    return "\n".join(lines) + "\n"


def adaptive_table(rows: Sequence[Adaptive]) -> str:
    lines = ["| Scene | Target | Adaptive, s | Uniform, s | Ratio |", "|---|---:|---:|---:|---:|"]
    for row in rows:
        lines.append(
            f"| `{row.scene}` | {row.target:g} % | {row.seconds:.3g} | {row.uniform_seconds:.3g} "
            f"| {row.ratio:.2f} |"
        )
    return "\n".join(lines) + "\n"


def work(options: argparse.Namespace) -> int:
    if options.runs < 2 and not options.target:
        raise ToolError("methods are compared by what two renders of each differ by, or more")
    for path in options.scenes:
        blend_file_there(path)
    options.output.mkdir(parents=True, exist_ok=True)
    rows: list[Row] = []
    adaptive: list[Adaptive] = []
    failed = False
    for path in options.scenes:
        try:
            for name, description in scenes(options, path):
                say(COMMAND, name)
                if options.target:
                    adaptive.append(adaptive_row(name, description, options))
                else:
                    rows.append(method_row(name, description, options))
                    say(COMMAND, rows[-1].reason)
        except ToolError as error:
            say(COMMAND, f"{path.stem}: {error}")
            failed = True
        figures = [*map(asdict, rows), *map(asdict, adaptive)]
        (options.output / "figures.json").write_text(json.dumps(figures, indent=1) + "\n")
    print(adaptive_table(adaptive) if options.target else methods_table(rows), end="")
    return 1 if failed else 0


def main() -> int:
    options = accuracy_lines.methods(sys.argv[1:])
    return ended(COMMAND, lambda: work(options))


if __name__ == "__main__":
    sys.exit(main())
