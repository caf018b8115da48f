"""Runs the whole suite of extremes (tests/extremes) and writes its report: a figure of every case
by every method, the worst of each group, and pictures of those that are farthest off."""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from vernier_tools import command_lines
from vernier_tools.extremes_report import Record, report, worst_first
from vernier_tools.images import write_png

ROOT = Path(__file__).resolve().parents[2]
COMMAND = "scripts/extremes"
RESULTS = "results.csv"
PICTURES = 6
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


@dataclass(frozen=True)
class Choice:
    """Which cases are run: those whose title and method hold `text`."""

    text: str
    large: bool
    integrators: list[str] | None

    def runs(self) -> Iterable[tuple[Any, str]]:
        cases, methods, _ = suite()
        for case in cases.all_cases():
            if (case.large or case.deep) and not self.large:
                continue
            for integrator in methods.methods_of(case):
                chosen = self.integrators is None or integrator in self.integrators
                if chosen and self.text in f"{case.title} by {integrator}":
                    yield case, integrator


def record_of(result: Any) -> Record:
    verdict = result.verdict
    return Record(result.case.group, result.case.name, result.integrator, verdict.passed,
                  verdict.value, verdict.error, verdict.figure, result.samples,
                  result.seconds)  # fmt: skip


def read_results(path: Path) -> list[Record]:
    """Those that were written before, the last of each case and method."""
    if not path.exists():
        return []
    kept = {}
    with path.open(newline="") as file:
        for row in csv.DictReader(file):
            record = Record(
                row["group"], row["name"], row["integrator"], row["passed"] == "True",
                float(row["off"]), float(row["error"]), row["figure"], float(row["samples"]),
                float(row["seconds"]),
            )  # fmt: skip
            kept[record.key] = record
    return list(kept.values())


def write_pictures(records: list[Record], runner: Any, choice: Choice, folder: Path) -> list[str]:
    """PNGs of the worst, normalised to their own brightness. Returns their lines of the report."""
    runs = {(case.group, case.name, by): (case, by) for case, by in choice.runs()}
    worst = [r for r in worst_first(records) if r.key in runs][:PICTURES]
    lines = []
    for number, record in enumerate(worst):
        picture = runner.run(*runs[record.key]).picture
        image = np.nan_to_num(np.asarray(picture, np.float64))
        scale = max(float(np.percentile(image, 98)), np.finfo(np.float64).tiny)
        shown = np.clip(image[::-1] / scale, 0, 1) ** (1 / 2.2)
        times = max(PICTURE_SIDE // max(shown.shape[:2]), 1)
        write_png(
            folder / f"worst_{number}.png",
            shown.repeat(times, 0).repeat(times, 1).astype(np.float32),
        )
        lines.append(f"![](worst_{number}.png) {record.title}: {record.short_figure}\n\n")
    return lines


def run(options: Any, choice: Choice, runner: Any, path: Path) -> list[Record]:
    """Runs what is chosen, and keeps every result at once."""
    records = read_results(path) if options.resume else []
    done = {record.key for record in records}
    begun = time.monotonic()
    with path.open("a" if records else "w", newline="") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Record)])
        if not records:
            writer.writeheader()
        for case, integrator in choice.runs():
            if (case.group, case.name, integrator) in done:
                continue
            if options.time is not None and time.monotonic() - begun > options.time:
                break
            record = record_of(runner.run(case, integrator))
            records.append(record)
            writer.writerow(asdict(record))
            file.flush()
            if not record.passed or sys.stderr.isatty():
                mark = "ok " if record.passed else "OFF"
                print(f"{mark} {record.title}: {record.figure}", file=sys.stderr, flush=True)
    return records


def main() -> int:
    options = command_lines.extremes(sys.argv[1:])
    folder: Path = options.output
    folder.mkdir(parents=True, exist_ok=True)
    _, _, runners = suite()
    runner = runners.Runner(runners.Effort(options.pictures, options.share))
    choice = Choice(options.only, not options.quick, options.methods)
    records = run(options, choice, runner, folder / RESULTS)
    if not records:
        print(f"{COMMAND}: error: no case is named so", file=sys.stderr)
        return 2
    pictures = write_pictures(records, runner, choice, folder)
    (folder / "report.md").write_text(report(records, pictures))
    failed = sum(not record.passed for record in records)
    print(f"{len(records) - failed} passed, {failed} failed: {folder / 'report.md'}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
