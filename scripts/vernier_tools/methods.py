"""Whether Auto chooses well, and whether adaptive sampling pays.

Methods render each small picture at equal processor time, several times, beside a long render.
The deviation of the pixels' values falls with the root of the time, so its square compares the
times that methods need to any error.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
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
#: Samples of the render that Auto chooses for: its pilot is a twentieth of these.
CHOSEN_FOR = 4096


@dataclass(frozen=True)
class Row:
    """One scene. `seconds` of processor time to an error of 5 %, by method."""

    scene: str
    seconds: dict[str, float]
    chosen: str
    reason: str

    @property
    def best(self) -> str:
        return min(self.seconds, key=lambda name: self.seconds[name])

    @property
    def ratio(self) -> float:
        """How much longer the chosen method takes than the best."""
        best = self.seconds[self.best]
        return self.seconds.get(self.chosen, math.nan) / best if best > 0.0 else math.nan


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


def seconds_to(error: float, runs: Sequence[CoreRender], reference: CoreRender) -> float:
    """By the runs' true deviations and their mean processor time."""
    values = np.array([run.values for run in runs])
    true = calibration.NORMAL_QUANTILE * calibration.deviation(
        values, reference.values, reference.halves
    )
    return float(np.mean([run.seconds for run in runs])) * (true / error) ** 2


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


def method_row(name: str, description: SceneDescription, options: argparse.Namespace) -> Row:
    """Raises ToolError."""
    scene = core_renders.compiled(description)
    threads = options.threads
    chosen, reason = choice(scene, threads)
    runs = {
        method: [
            core_renders.rendered(scene, method, seed, threads=threads, time_limit=options.seconds)
            for seed in range(1, options.runs + 1)
        ]
        for method in options.integrators
    }
    # All methods are of equal expectation: long renders by each, of which the better counts more.
    long = [
        core_renders.rendered(
            scene, method, REFERENCE_SEED, threads=threads,
            time_limit=options.reference_time / len(options.integrators),
        )
        for method in options.integrators
    ]  # fmt: skip
    reference = weighted(long)
    seconds = {method: seconds_to(ERROR, each, reference) for method, each in runs.items()}
    return Row(name, seconds, chosen, reason)


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
    scene = core_renders.compiled(description)
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
    description = sized(described(path), options.width)
    yield path.stem, description
    if options.variations:
        for what, changed in variations(description):
            yield f"{path.stem}, {what}", changed


def methods_table(rows: Sequence[Row]) -> str:
    names = list(rows[0].seconds) if rows else []
    head = [f"`{name.lower()}`, s" for name in names]
    lines = [f"| Scene | {' | '.join(head)} | Auto takes | times the best |"]
    lines.append("|---|" + "---:|" * len(names) + "---|---:|")
    for row in rows:
        cells = [f"{row.seconds[name]:.3g}" for name in names]
        lines.append(
            f"| `{row.scene}` | {' | '.join(cells)} | `{row.chosen.lower()}` | {row.ratio:.2f} |"
        )
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
