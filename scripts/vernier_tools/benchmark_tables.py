"""The benchmark's results as Markdown tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from vernier_tools.jobs import ENGINES

Figures = Mapping[str, Any]


def markdown(results: Figures) -> str:
    """All tables. Ratios are Vernier's figure over Cycles'."""
    parts = [
        f"{results['machine']}; medians (of errors: means) of {results['repeats']} renders, each "
        "engine in a process of its own, in turns. Ratios are Vernier over Cycles.\n"
    ]
    if results["scenes"]:
        parts += ["## Scenes\n", scenes_note(results), scene_table(results["scenes"])]
    if results["rays"]:
        parts += ["## Rays\n", RAYS_NOTE, ray_table(results["rays"])]
    if results["photons"]:
        parts += ["## Photons\n", PHOTONS_NOTE, photon_table(results["photons"])]
    if results["sizes"]:
        parts += ["## Sizes\n", SIZES_NOTE, size_table(results["sizes"])]
    if results["failures"]:
        parts += ["## Failures\n", "\n".join(f"- {line}" for line in results["failures"]) + "\n"]
    return "\n".join(parts)


RAYS_NOTE = (
    "Million rays per second of processor time on one thread: of a render, and of Embree casting "
    "the same rays in the same order with nothing in between.\n"
)


PHOTONS_NOTE = (
    "On one thread: seconds of processor time that a million photons take to be traced, stored and "
    "indexed, and a million camera paths; bytes that a photon keeps; microseconds that the 50 "
    "photons nearest to a point take, and SciPy's tree for the same points.\n"
)


SIZES_NOTE = (
    "Generated scenes. Export and build: seconds of processor time from the call until sampling "
    "begins. First tile: by the clock. Memory: by how much the process grew at its peak.\n"
)


def scenes_note(results: Figures) -> str:
    return (
        f"Renders of {results['seconds']:g} s. Samples are million pixel samples per second of "
        "processor time since sampling began. The relative squared error is the mean of "
        "(I - R)^2 / (R^2 + 0.01 mean(R)^2), the reference's own noise subtracted, brought to "
        "equal processor time, preparation included; in parentheses where a thousandth of the "
        "pixels carries half of it: one render does not tell it then. The mean ratio is of the "
        f"references, {results['reference_seconds']:g} s by each engine.\n"
    )


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def column_heads(engines: Sequence[str], name: str, ratio: bool = True) -> list[str]:
    heads = [f"{ENGINES[engine]} {name}" for engine in engines]
    return [*heads, "ratio"] if ratio and paired(engines) else heads


def paired(engines: Sequence[str]) -> bool:
    return set(engines) == {"vernier", "cycles"}


def cells(entry: Figures, key: str, show: Callable[[float], str]) -> list[str]:
    """One cell for each engine, then the ratio where both are there."""
    engines = entry["engines"]
    values = [show(figures[key]) for figures in engines.values()]
    if paired(list(engines)):
        ours, theirs = engines["vernier"][key], engines["cycles"][key]
        values.append(f"{ours / theirs:.2f}" if theirs > 0 else "")
    return values


def error_cells(entry: Figures) -> list[str]:
    """As `cells`; in parentheses where half of an error or more is in one pixel of a thousand."""
    shown = cells(entry, "error", lambda v: f"{v:.3g}")
    runs = [run for figures in entry["engines"].values() for run in figures["runs"]]
    doubtful = any(run["worst_share"] > 0.5 for run in runs)
    return [f"({text})" for text in shown] if doubtful else shown


def scene_table(entries: Sequence[Figures]) -> str:
    engines = list(entries[0]["engines"])
    head = ["scene", "triangles", "pixels"]
    head += column_heads(engines, "Msamples/s CPU")
    head += column_heads(engines, "error")
    head += column_heads(engines, "first tile, s")
    head += column_heads(engines, "memory, MiB")
    head += ["mean ratio", "reference noise"]
    rows = []
    for entry in entries:
        row = [entry["scene"], f"{entry['triangles']:,}", f"{entry['width']}x{entry['height']}"]
        row += cells(entry, "samples_per_cpu_second", lambda v: f"{v / 1e6:.3f}")
        row += error_cells(entry)
        row += cells(entry, "first_tile", lambda v: f"{v:.2f}")
        row += cells(entry, "memory", lambda v: f"{v / 2**20:.0f}")
        if "mean_ratio" in entry:
            row.append(f"{entry['mean_ratio']:.4f} ± {entry['mean_ratio_error']:.4f}")
        else:
            row.append("")
        rows.append([*row, f"{entry['reference_noise']:.2g}"])
    return table(head, rows)


def ray_table(entries: Sequence[Figures]) -> str:
    rows = []
    for entry in entries:
        rates = [entry["rendered"], entry["bare"]]
        shown = [f"{rate / 1e6:.2f}" for rate in rates]
        rows.append([entry["scene"], *shown, f"{rates[0] / rates[1]:.2f}"])
    return table(["scene", "Vernier Mrays/s", "Embree Mrays/s", "ratio"], rows)


def photon_table(entries: Sequence[Figures]) -> str:
    rows = [
        [
            entry["scene"],
            f"{entry['photons']:,}",
            f"{entry['bytes_of_photon']:.0f}",
            f"{entry['map_seconds']:.2f}",
            f"{entry['camera_seconds']:.2f}",
            f"{entry['query_seconds'] * 1e6:.1f}",
            f"{entry['scipy_seconds'] * 1e6:.1f}",
        ]
        for entry in entries
    ]
    head = ["scene", "photons", "bytes each", "a million, s", "camera paths, s"]
    return table([*head, "nearest 50, µs", "SciPy, µs"], rows)


def size_table(entries: Sequence[Figures]) -> str:
    engines = list(entries[0]["engines"])
    head = ["triangles", "kind"]
    head += column_heads(engines, "export and build, s CPU")
    head += column_heads(engines, "first tile, s")
    head += column_heads(engines, "memory, MiB")
    rows = []
    for entry in entries:
        row = [f"{entry['triangles']:,}", "instanced" if entry["instanced"] else "flat"]
        row += cells(entry, "preparation", lambda v: f"{v:.2f}")
        row += cells(entry, "first_tile", lambda v: f"{v:.2f}")
        row += cells(entry, "memory", lambda v: f"{v / 2**20:.0f}")
        rows.append(row)
    return table(head, rows)
