"""One picture as it refines, side by side, each step with its error."""

from __future__ import annotations

import argparse
import html
import json
import math
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from vernier_tools import accuracy_lines, jobs
from vernier_tools.comparison_page import STYLE, figure
from vernier_tools.errors import blend_file_there, ended, say

COMMAND = "scripts/progress"


def render_steps(options: argparse.Namespace, folder: Path) -> list[jobs.Render]:
    """One render, resumed; its pictures are `SAMPLES.png` in `folder`. Raises ToolError."""
    steps = []
    with tempfile.TemporaryDirectory() as temporary:
        for samples in options.samples:
            say(COMMAND, f"{samples} samples")
            job = jobs.Job(
                engine=f"vernier-{options.integrator.lower()}",
                blend=str(options.scene),
                output=str(Path(temporary, "step")),
                samples=samples,
                threads=options.threads,
                resolution=options.resolution,
                view=True,
                settings={"checkpoint": str(Path(temporary, "state")), "resume": True},
            )
            steps.append(jobs.run(job).renders[0])
            Path(temporary, "step-0.png").replace(folder / f"{samples}.png")
    return steps


def caption(step: jobs.Render, seconds: float) -> str:
    """`seconds` of rendering until then."""
    error = f"error {100 * step.error:.2g} %" if math.isfinite(step.error) else "error unknown"
    return f"{step.samples:.0f} samples per pixel, {seconds:.1f} s, {error}"


def captions(steps: Sequence[jobs.Render]) -> list[str]:
    spent = 0.0
    lines = []
    for step in steps:
        spent += step.sampling
        lines.append(caption(step, spent))
    return lines


def write_page(path: Path, title: str, lines: Sequence[str], pictures: Sequence[str]) -> None:
    title = f"{html.escape(title)}, as it refines"
    parts = [
        "<!DOCTYPE html>",
        f'<html lang="en"><head><meta charset="utf-8"><title>{title}</title>',
        f"<style>{STYLE} body {{ max-width: none; }}</style></head><body><h1>{title}</h1>",
        "<p>One render, stopped and resumed. Its error is the 95th percentile of the pixels' 95 % "
        "confidence half-widths, relative to each pixel.</p>",
        *(figure([name], line) for name, line in zip(pictures, lines, strict=True)),
        "</body></html>",
    ]
    path.write_text("\n".join(parts) + "\n", encoding="utf-8")


def work(options: argparse.Namespace) -> int:
    blend_file_there(options.scene)
    output: Path = options.output or Path("out", "progress", options.scene.stem)
    output.mkdir(parents=True, exist_ok=True)
    steps = render_steps(options, output)
    lines = captions(steps)
    (output / "figures.json").write_text(
        json.dumps([asdict(step) for step in steps], indent=1) + "\n"
    )
    pictures = [f"{samples}.png" for samples in options.samples]
    write_page(output / "index.html", options.scene.stem, lines, pictures)
    print("\n".join([*lines, str(output / "index.html")]))
    return 0


def main() -> int:
    options = accuracy_lines.progress(sys.argv[1:])
    return ended(COMMAND, lambda: work(options))


if __name__ == "__main__":
    sys.exit(main())
