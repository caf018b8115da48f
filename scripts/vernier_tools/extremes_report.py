"""The report of the suite of extremes: the worst of each group, and every case's figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

#: Methods that blur light, by how much depends on the samples.
MERGING = ("VCM", "SPPM", "PHOTON")


@dataclass(frozen=True)
class Record:
    """What one case by one method has shown."""

    group: str
    name: str
    integrator: str
    passed: bool
    #: Relative deviation (where a picture must be black: a radiance), and its standard error.
    off: float
    error: float
    figure: str
    samples: float
    seconds: float

    @property
    def key(self) -> tuple[str, str, str]:
        return self.group, self.name, self.integrator

    @property
    def title(self) -> str:
        return f"{self.group}: {self.name} by {self.integrator}"

    @property
    def short_figure(self) -> str:
        return self.figure.replace(" off, error ", " ± ")

    @property
    def beyond_noise(self) -> float:
        """The least deviation that its error allows, at 95 %."""
        return abs(self.off) - 2.0 * self.error


def worst_first(records: Sequence[Record]) -> list[Record]:
    return sorted(records, key=lambda r: (r.passed, -r.beyond_noise))


def worst_of(records: Sequence[Record]) -> str:
    """The farthest off beyond twice its own error, in words."""
    if not records:
        return ""
    worst = worst_first(records)[0]
    if worst.passed and worst.beyond_noise <= 0:
        return "none"
    return f"{worst.short_figure}: {worst.name} by {worst.integrator}"


def groups_table(records: Sequence[Record]) -> str:
    """A row per group, with the farthest off beyond twice its error."""
    lines = [
        "| Group | Runs | Off | Samples | Farthest, methods without bias | Methods that merge |",
        "|---|---|---|---|---|---|",
    ]
    for group in dict.fromkeys(record.group for record in records):
        own = [record for record in records if record.group == group]
        failed = sum(not record.passed for record in own)
        samples = sum(record.samples for record in own)
        true = worst_of([record for record in own if record.integrator not in MERGING])
        merged = worst_of([record for record in own if record.integrator in MERGING])
        lines.append(f"| {group} | {len(own)} | {failed} | {samples:.1e} | {true} | {merged} |")
    return "\n".join(lines) + "\n"


def cases_table(records: Sequence[Record]) -> str:
    """Cases by row, methods by column."""
    columns = list(dict.fromkeys(record.integrator for record in records))
    rows: dict[str, dict[str, str]] = {}
    for record in records:
        mark = "" if record.passed else "**off** "
        title = f"{record.group}: {record.name}"
        figure = "finite" if record.figure.endswith(" samples") else record.short_figure
        rows.setdefault(title, {})[record.integrator] = mark + figure
    lines = ["| Case | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    for title, cells in rows.items():
        lines.append(f"| {title} | " + " | ".join(cells.get(c, "") for c in columns) + " |")
    return "\n".join(lines) + "\n"


def report(records: Sequence[Record], pictures: Sequence[str]) -> str:
    """Markdown. `pictures`: paragraphs of the worst."""
    failed = [record for record in records if not record.passed]
    samples = sum(record.samples for record in records)
    parts = [
        f"# The suite of extremes\n\n{len(records)} runs, {len(failed) or 'none'} of them off; "
        f"{samples:.1e} samples.\n\nA figure is a relative deviation and its standard error. "
        "A run that passes has no value that is not finite, none below zero and no sample "
        "dropped.\n\n",
        groups_table(records),
    ]
    if failed:
        parts.append("\n## Off\n\n")
        parts += [f"- {record.title}: {record.short_figure}\n" for record in failed]
    if pictures:
        parts += ["\n## The farthest off\n\n", *pictures]
    parts += ["\n## Every case\n\n", cases_table(records)]
    return "".join(parts)
