"""Are the error bars true? Renders small pictures again and again beside a long one.

For every scene, method and stopping rule: the share of pixels within their stated 95 % half-width,
the picture's error as stated (the median over runs) and as it is, and the bias of the mean.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vernier_tools import accuracy_lines, calibration, core_renders
from vernier_tools.describe import described, sized
from vernier_tools.errors import ToolError, blend_file_there, ended, say

COMMAND = "scripts/calibrate"
#: Far from the seeds of the runs.
REFERENCE_SEED = 1_000_001
#: Methods whose samples add to other pixels than their own: their batches grow more slowly.
SHARES = {"PATH": 4, "WHITTED": 4}
SPLATTING_SHARE = 16


@dataclass(frozen=True)
class Row:
    """One method under one rule on one scene. `claimed` and `true` are the picture's errors."""

    scene: str
    integrator: str
    rule: str
    runs: int
    samples: float
    seconds: float
    inside: float
    claimed: float
    true: float
    bias: float
    bias_error: float


def samples_of(batches: int, share: int) -> int:
    """Samples per pixel of the first `batches` batches."""
    from engine_core import probe

    total = 0
    for _ in range(batches):
        total += probe.batch_samples(total, share)
    return total


def limits(rule: str, integrator: str) -> dict[str, Any]:
    """The settings of a rule: a number of batches, `time=SECONDS` or `target=PERCENT`."""
    name, _, value = rule.partition("=")
    if name == "time":
        return {"time_limit": float(value)}
    if name == "target":
        return {"target_error": float(value)}
    return {"samples": samples_of(int(rule), SHARES.get(integrator, SPLATTING_SHARE))}


def measure(
    scene: Any, name: str, options: argparse.Namespace, reference: core_renders.CoreRender
) -> Iterator[Row]:
    """All rows of one compiled scene. Raises ToolError."""
    truth, slack = reference.values, reference.halves
    for rule in options.rules:
        for integrator in options.integrators:
            settings = {"threads": options.threads, **limits(rule, integrator)}
            runs = [
                core_renders.rendered(scene, integrator, seed, **settings)
                for seed in range(options.runs)
            ]
            values = np.array([run.values for run in runs])
            halves = np.array([run.halves for run in runs])
            bias, bias_error = calibration.bias(values, truth)
            yield Row(
                name,
                integrator,
                rule,
                len(runs),
                float(np.mean([run.samples for run in runs])),
                float(np.mean([run.seconds for run in runs])),
                calibration.coverage(values, halves, truth, slack),
                float(np.median([run.error for run in runs])),
                calibration.true_error(values, truth, slack),
                bias,
                bias_error,
            )


def markdown(rows: list[Row]) -> str:
    lines = [
        "| Scene | Method | Rule | Samples | Within, % | Stated error | True error | Ratio "
        "| Bias of the mean, % |",
        "|---|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        ratio = row.claimed / row.true if row.true else math.nan
        lines.append(
            f"| `{row.scene}` | `{row.integrator.lower()}` | {row.rule} | {row.samples:.0f} "
            f"| {100 * row.inside:.1f} | {percent(row.claimed)} | {percent(row.true)} "
            f"| {ratio:.2f} | {100 * row.bias:+.2f} ± {100 * row.bias_error:.2f} |"
        )
    return "\n".join(lines) + "\n"


def percent(value: float) -> str:
    """Three digits, yet never an exponent."""
    share = 100.0 * value
    return f"{share:.3g} %" if not share >= 999.5 else f"{share:.0f} %"


def work(options: argparse.Namespace) -> int:
    output: Path = options.output
    for scene in options.scenes:
        blend_file_there(scene)
    output.mkdir(parents=True, exist_ok=True)
    rows: list[Row] = []
    failed = False
    for scene in options.scenes:
        say(COMMAND, scene.stem)
        try:
            compiled = core_renders.compiled(sized(described(scene), options.width))
            reference = core_renders.rendered(
                compiled,
                options.reference,
                REFERENCE_SEED,
                samples=options.reference_samples,
                threads=options.threads,
            )
            for row in measure(compiled, scene.stem, options, reference):
                rows.append(row)
                (output / "figures.json").write_text(
                    json.dumps([asdict(row) for row in rows], indent=1) + "\n"
                )
        except ToolError as error:
            say(COMMAND, f"{scene.stem}: {error}")
            failed = True
    print(markdown(rows), end="")
    return 1 if failed else 0


def main() -> int:
    options = accuracy_lines.calibrate(sys.argv[1:])
    return ended(COMMAND, lambda: work(options))


if __name__ == "__main__":
    sys.exit(main())
