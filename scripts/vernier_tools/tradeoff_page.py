"""What a measured trade looks like: curves of error against time, tables, pictures."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vernier_tools.comparison_page import STYLE, figure
from vernier_tools.jobs import ENGINES

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c510a", "#444444")
WIDTH, HEIGHT, MARGIN = 860, 520, 60


def markdown(figures: Mapping[str, Any]) -> str:
    """The table of a scene, and what failed."""
    targets = list(next(iter(figures["engines"].values()))["seconds_to"])
    head = ["Method", "slope", *(f"s to {target}" for target in targets)]
    head += ["error", "95 % of pixels below", "bias of the mean", "FLIP", "memory, MiB"]
    rows = [f"| {' | '.join(head)} |", "|---|" + "---:|" * (len(head) - 1)]
    for engine, row in figures["engines"].items():
        cells = [
            ENGINES[engine],
            f"{row['slope']:.2f}",
            *(seconds_text(value, row["measured_to"]) for value in row["seconds_to"].values()),
            f"{two_digits(100 * row['error'])} %",
            f"{two_digits(100 * row['percentile'])} %",
            bias_text(row["bias"], row["bias_error"]),
            f"{row['flip']:.3f}",
            f"{row['memory'] / 2**20:.0f}",
        ]
        rows.append(f"| {' | '.join(cells)} |")
    title = f"**{figures['scene']}** (reference known to {100 * figures['reference_error']:.2g} %)"
    return (
        "\n".join([title, "", *rows, *(f"\nfailed: {text}" for text in figures["failures"])]) + "\n"
    )


def two_digits(value: float) -> str:
    """Two digits, yet never an exponent, which `.2g` writes from 99.5 on."""
    return f"{value:.2g}" if value < 99.5 else f"{value:.0f}"


def bias_text(bias: float, error: float) -> str:
    """Without an error where there is one render only."""
    known = f" ± {100 * error:.2f}" if math.isfinite(error) else ""
    return f"{100 * bias:+.2f}{known} %"


def seconds_text(seconds: float, measured_to: float) -> str:
    """In parentheses where it lies beyond what was measured."""
    if not math.isfinite(seconds) or seconds > 1e7:
        return "(never)"
    text = two_digits(seconds)
    return text if seconds <= 1.5 * measured_to else f"({text})"


def write_page(path: Path, figures: Mapping[str, Any]) -> None:
    """Writes the page; each method's longest picture lies beside it."""
    title = f"{html.escape(figures['scene'])}: error against time"
    parts = [
        "<!DOCTYPE html>",
        f'<html lang="en"><head><meta charset="utf-8"><title>{title}</title>',
        f"<style>{STYLE}</style></head><body><h1>{title}</h1>",
        curves(figures),
        "<p>Root of the relative squared error against seconds, both logarithmic; lines are fitted "
        f"by least squares. The reference is known to {100 * figures['reference_error']:.2g} %; "
        "its own error is taken off. Times in parentheses lie beyond what was measured.</p>",
        table(markdown(figures)),
        "<h2>Pictures of the longest renders, at equal time</h2>",
        *(figure([f"{engine}.png"], ENGINES[engine]) for engine in figures["engines"]),
        "</body></html>",
    ]
    path.write_text("\n".join(parts) + "\n", encoding="utf-8")


def table(text: str) -> str:
    """The Markdown table as HTML."""
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]
    cells = ("".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows)
    return "<table>" + "".join(f"<tr>{row}</tr>" for row in cells) + "</table>"


class Axis:
    """A logarithmic axis over the values, from `start` to `end` in the picture."""

    def __init__(self, values: list[float], start: float, end: float) -> None:
        low, high = math.log10(min(values)), math.log10(max(values))
        pad = max(0.05, 0.05 * (high - low))
        self.low, self.high = low - pad, high + pad
        self.start, self.end = start, end

    def place(self, value: float) -> float:
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def ticks(self) -> list[float]:
        decades = range(math.floor(self.low), math.ceil(self.high) + 1)
        values = [digit * 10.0**decade for decade in decades for digit in (1, 2, 5)]
        return [value for value in values if self.low <= math.log10(value) <= self.high]


def curves(figures: Mapping[str, Any]) -> str:
    """The plot, as SVG."""
    points = [point for point in figures["points"] if point["error"] > 0]
    if not points:
        return "<p>Every error lies below the reference's own.</p>"
    x = Axis([point["seconds"] for point in points], MARGIN, WIDTH - 190)
    y = Axis([point["error"] for point in points], HEIGHT - MARGIN, 20)
    parts = [f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" font-size="12">']
    for value in x.ticks():
        at = x.place(value)
        parts.append(stroke(at, y.start, at, y.end, "#ddd"))
        parts.append(label(at, HEIGHT - MARGIN + 18, f"{value:g} s", "middle"))
    for value in y.ticks():
        at = y.place(value)
        parts.append(stroke(x.start, at, x.end, at, "#ddd"))
        parts.append(label(MARGIN - 6, at + 4, f"{100 * value:g} %", "end"))
    for number, (engine, row) in enumerate(figures["engines"].items()):
        color = COLORS[number % len(COLORS)]
        own = [point for point in points if point["engine"] == engine]
        for point in own:
            center = f'cx="{x.place(point["seconds"]):.1f}" cy="{y.place(point["error"]):.1f}"'
            parts.append(f'<circle {center} r="3.5" fill="{color}"/>')
        if own:
            first, last = (f(point["seconds"] for point in own) for f in (min, max))
            low, high = (math.exp(row["offset"]) * t ** row["slope"] for t in (first, last))
            parts.append(stroke(x.place(first), y.place(low), x.place(last), y.place(high), color))
        text = f"{ENGINES[engine]} ({row['slope']:.2f})"
        parts.append(f'<circle cx="{WIDTH - 175}" cy="{30 + 20 * number}" r="4" fill="{color}"/>')
        parts.append(label(WIDTH - 165, 34 + 20 * number, text, "start"))
    return "".join([*parts, "</svg>"])


def stroke(x0: float, y0: float, x1: float, y1: float, color: str) -> str:
    ends = f'x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"'
    return f'<line {ends} stroke="{color}" stroke-width="1.5"/>'


def label(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{html.escape(text)}</text>'
