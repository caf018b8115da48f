"""Runs the whole suite of extremes (tests/extremes) and writes its report: a table of every case by
every method, and pictures of those that are farthest off."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from vernier_tools import command_lines
from vernier_tools.images import write_png

ROOT = Path(__file__).resolve().parents[2]
COMMAND = "scripts/extremes"
PICTURES = 12
#: Sides of a picture in the report, pixels at the least.
PICTURE_SIDE = 96


def suite() -> Any:
    """The suite's modules, which live beside its tests."""
    for folder in ("extremes", "support"):
        sys.path.insert(0, str(ROOT / "tests" / folder))
    import extreme_cases
    import extreme_methods
    import extreme_runner

    return extreme_cases, extreme_methods, extreme_runner


def run(share: float, pictures: int, chosen: str, large: bool) -> Iterable[Any]:
    """Results, one by one, of the cases whose title and method hold `chosen`."""
    cases, methods, runners = suite()
    runner = runners.Runner(runners.Effort(pictures, share))
    for case in cases.all_cases():
        if (case.large or case.deep) and not large:
            continue
        for integrator in methods.methods_of(case):
            if chosen in f"{case.title} by {integrator}":
                yield runner.run(case, integrator)


def table(results: list[Any]) -> str:
    """Cases by row, methods by column. A figure is a relative deviation and its standard error."""
    columns = list(dict.fromkeys(result.integrator for result in results))
    rows: dict[str, dict[str, str]] = {}
    for result in results:
        mark = "" if result.verdict.passed else "**off** "
        figure = result.verdict.figure.replace(" off, error", " ±")
        rows.setdefault(result.case.title, {})[result.integrator] = mark + figure
    lines = ["| Case | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    for title, cells in rows.items():
        lines.append(f"| {title} | " + " | ".join(cells.get(c, "") for c in columns) + " |")
    return "\n".join(lines) + "\n"


def write_pictures(results: list[Any], folder: Path) -> list[str]:
    """PNGs of the worst, normalised to their own brightness. Returns their lines of the report."""
    lines = []
    worst = sorted(results, key=lambda r: (r.verdict.passed, -abs(r.verdict.value)))[:PICTURES]
    for number, result in enumerate(worst):
        image = np.nan_to_num(np.asarray(result.picture, np.float64))
        scale = max(float(np.percentile(image, 98)), np.finfo(np.float64).tiny)
        shown = np.clip(image[::-1] / scale, 0, 1) ** (1 / 2.2)
        times = max(PICTURE_SIDE // max(shown.shape[:2]), 1)
        write_png(
            folder / f"worst_{number}.png",
            shown.repeat(times, 0).repeat(times, 1).astype(np.float32),
        )
        lines.append(
            f"![](worst_{number}.png) {result.case.title} by {result.integrator}: "
            f"{result.verdict.figure}\n"
        )
    return lines


def main() -> int:
    options = command_lines.extremes(sys.argv[1:])
    folder: Path = options.output
    folder.mkdir(parents=True, exist_ok=True)
    results = []
    for result in run(options.share, options.pictures, options.only, not options.quick):
        results.append(result)
        if not result.verdict.passed or sys.stderr.isatty():
            mark = "ok " if result.verdict.passed else "OFF"
            print(f"{mark} {result.case.title} by {result.integrator}: {result.verdict.figure}",
                  file=sys.stderr, flush=True)  # fmt: skip
    if not results:
        print(f"{COMMAND}: error: no case is named so", file=sys.stderr)
        return 2
    failed = sum(not result.verdict.passed for result in results)
    lines = [f"# The suite of extremes\n\n{len(results)} runs, {failed} of them off.\n\n"]
    lines += ["A figure is a relative deviation and its standard error.\n\n", table(results)]
    lines += ["\n## The farthest off\n\n", *write_pictures(results, folder)]
    (folder / "report.md").write_text("".join(lines))
    print(f"{len(results) - failed} passed, {failed} failed: {folder / 'report.md'}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
