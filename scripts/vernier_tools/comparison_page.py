"""The HTML page of a comparison: pictures, differences, figures, and how to read them."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 1.5rem auto; max-width: 1240px;
       padding: 0 1rem; color: #222; background: #fafafa; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.1rem; margin-top: 2rem; }
figure { display: inline-block; margin: 0 1rem 1.2rem 0; vertical-align: top; max-width: 100%; }
figure img { display: block; min-width: 384px; max-width: 100%; image-rendering: pixelated;
             background: #888; }
figcaption { font-size: 0.9rem; max-width: 36rem; padding-top: 0.3rem; color: #444; }
table { border-collapse: collapse; }
th, td { padding: 0.25rem 0.8rem; border-bottom: 1px solid #ddd; }
th { text-align: left; } td { text-align: right; font-variant-numeric: tabular-nums; }
.swap img:last-of-type { display: none; }
.swap:hover img:first-of-type { display: none; } .swap:hover img:last-of-type { display: block; }
"""


def write_page(path: Path, title: str, numbers: Mapping[str, Any]) -> None:
    """Writes the page for the figures that `compare.figures` gives; the PNGs lie beside it."""
    names = [html.escape(name) for name in numbers["engines"]]
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        f"<title>{html.escape(title)}: {names[0]} and {names[1]}</title>",
        f"<style>{STYLE}</style></head><body>",
        f"<h1>{html.escape(title)}: {names[0]} beside {names[1]}</h1>",
        *picture_section(names),
        *difference_section(names, numbers),
        "<h2>Figures</h2>",
        agreement_table(numbers),
        engine_table(names, numbers),
        *warning_section(names, numbers),
        "</body></html>",
    ]
    path.write_text("\n".join(parts) + "\n", encoding="utf-8")


def figure(images: Sequence[str], caption: str, kind: str = "") -> str:
    tags = "".join(f'<img src="{image}" alt="">' for image in images)
    return f'<figure class="{kind}">{tags}<figcaption>{caption}</figcaption></figure>'


def picture_section(names: Sequence[str]) -> list[str]:
    first, second = "picture-0.png", "picture-1.png"
    return [
        "<h2>Pictures</h2>",
        figure([first], names[0]),
        figure([second], names[1]),
        figure([first, second], f"{names[0]}; {names[1]} under the pointer", "swap"),
    ]


def difference_section(names: Sequence[str], numbers: Mapping[str, Any]) -> list[str]:
    block = numbers["block"]
    return [
        "<h2>Differences</h2>",
        figure(
            ["difference.png"],
            "Difference of luminance relative to the mean of both: "
            f"red where {names[0]} is brighter, blue where {names[1]} is; full colour at 50 %.",
        ),
        figure(
            ["blocks.png"],
            f"The same over blocks of {block} by {block} pixels, in standard errors: full colour "
            "at 5. Noise alone gives pale patches without a pattern.",
        ),
        figure(["flip.png"], "FLIP: what an eye would see when the pictures are swapped."),
    ]


def agreement_table(numbers: Mapping[str, Any]) -> str:
    noise = sum(numbers["relative_squared_noise"])
    rows = [
        ("Mean ratio", f"{numbers['mean_ratio']:.5f} &plusmn; {numbers['mean_ratio_error']:.5f}"),
        ("Relative squared difference", f"{numbers['relative_squared_difference']:.4g}"),
        ("… of which noise explains", f"{noise:.4g}"),
        (
            "Worst block",
            f"{numbers['worst_block_z']:.2f} standard errors; by noise alone with probability "
            f"{numbers['worst_block_probability']:.3g}",
        ),
        ("Mean FLIP", f"{numbers['flip_mean']:.4f}"),
    ]
    body = "".join(f"<tr><th>{name}</th><td>{value}</td></tr>" for name, value in rows)
    note = (
        "<p>The noise is estimated from the two halves of each render. Where few samples carry "
        "most of the light (fireflies), it is underestimated, and so are the standard errors.</p>"
    )
    return f"<table>{body}</table>{note}"


def engine_table(names: Sequence[str], numbers: Mapping[str, Any]) -> str:
    outcomes = numbers["outcomes"]
    renders = [outcome["renders"] for outcome in outcomes]
    pixels = [outcome["width"] * outcome["height"] for outcome in outcomes]
    rows: list[tuple[str, list[str]]] = [
        ("Samples per pixel", [f"{sum(r['samples'] for r in rs)}" for rs in renders]),
        ("Seconds, both halves", [f"{sum(r['seconds'] for r in rs):.2f}" for rs in renders]),
        ("Processor seconds", [f"{sum(r['cpu'] for r in rs):.2f}" for rs in renders]),
        ("Seconds before sampling", [f"{renders_min(rs, 'first_sample'):.3f}" for rs in renders]),
        (
            "Million samples per second",
            [
                f"{sum(r['samples'] for r in rs) * p / sum(r['sampling'] for r in rs) / 1e6:.3f}"
                for rs, p in zip(renders, pixels, strict=True)
            ],
        ),
        ("Relative squared noise", [f"{n:.4g}" for n in numbers["relative_squared_noise"]]),
        ("Peak memory, MiB", [f"{renders_max(rs, 'peak_memory') / 2**20:.0f}" for rs in renders]),
        ("… grown by", [f"{renders_max(rs, 'memory') / 2**20:.0f}" for rs in renders]),
        ("Values not finite", [str(n) for n in numbers["not_finite"]]),
        ("Blender", [html.escape(outcome["version"]) for outcome in outcomes]),
    ]
    head = "<tr><th></th>" + "".join(f"<th>{name}</th>" for name in names) + "</tr>"
    body = "".join(
        f"<tr><th>{name}</th>" + "".join(f"<td>{value}</td>" for value in values) + "</tr>"
        for name, values in rows
    )
    return f"<table>{head}{body}</table>"


def renders_min(renders: Sequence[Mapping[str, Any]], key: str) -> float:
    return min(float(render[key]) for render in renders)


def renders_max(renders: Sequence[Mapping[str, Any]], key: str) -> float:
    return max(float(render[key]) for render in renders)


def warning_section(names: Sequence[str], numbers: Mapping[str, Any]) -> list[str]:
    parts = ["<h2>What was approximated or reported</h2>"]
    for name, outcome in zip(names, numbers["outcomes"], strict=True):
        items = "".join(f"<li>{html.escape(text)}</li>" for text in outcome["warnings"])
        parts.append(f"<h3>{name}</h3>" + (f"<ul>{items}</ul>" if items else "<p>Nothing.</p>"))
    return parts
