"""Renders a .blend file with Vernier and with Cycles and writes a page that compares the two."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from vernier_tools import command_lines, images, jobs, metrics
from vernier_tools.comparison_page import write_page
from vernier_tools.errors import ToolError, blend_file_there, ended
from vernier_tools.images import FloatImage

COMMAND = "scripts/compare_cycles"


@dataclass(frozen=True)
class Side:
    """One engine's part of the comparison."""

    name: str
    outcome: jobs.Outcome
    halves: tuple[FloatImage, FloatImage]  # linear; values that were not finite are 0
    view: FloatImage  # as displayed, in [0, 1]
    not_finite: int  # such values, in both halves

    @property
    def picture(self) -> FloatImage:
        return np.asarray((self.halves[0] + self.halves[1]) / 2, np.float32)


def render_side(options: argparse.Namespace, number: int, folder: Path) -> Side:
    """Renders both halves with one engine; seeds differ between the sides too."""
    engine = options.engines[number]
    samples = options.samples or (0 if options.time else 256)
    job = jobs.Job(
        engine=engine,
        blend=str(options.scene),
        output=str(folder / f"{number}-{engine}"),
        seeds=(options.seed + 2 * number, options.seed + 2 * number + 1),
        samples=(samples + 1) // 2,
        time=(options.time or 0.0) / 2,
        threads=options.threads,
        resolution=options.resolution,
        view=True,
    )
    print(f"{COMMAND}: rendering with {jobs.ENGINES[engine]}", file=sys.stderr, flush=True)
    outcome = jobs.run(job)
    first, second = (images.read_combined(Path(f"{job.output}-{seed}.exr")) for seed in job.seeds)
    not_finite = sum(int(np.count_nonzero(~np.isfinite(half))) for half in (first, second))
    for half in (first, second):
        np.nan_to_num(half, copy=False, nan=0.0, posinf=0.0, neginf=0.0)
    views = [images.read_combined(Path(f"{job.output}-{seed}.png")) for seed in job.seeds]
    view = np.asarray((views[0] + views[1]) / 2, np.float32)
    return Side(jobs.ENGINES[engine], outcome, (first, second), view, not_finite)


def figures(sides: tuple[Side, Side], flip: float) -> dict[str, object]:
    """All numbers of the page, ready for JSON."""
    reference = np.asarray((sides[0].picture + sides[1].picture) / 2, np.float32)
    agree = metrics.agreement(sides[0].halves, sides[1].halves)
    return {
        "engines": [side.name for side in sides],
        "mean_ratio": agree.ratio,
        "mean_ratio_error": agree.ratio_error,
        "relative_squared_difference": metrics.relative_squared_error(
            sides[0].picture, sides[1].picture
        ),
        "relative_squared_noise": [
            metrics.relative_noise(side.halves, reference) for side in sides
        ],
        "worst_block_z": agree.worst_z,
        "worst_block_probability": agree.probability,
        "block": agree.block,
        "flip_mean": flip,
        "not_finite": [side.not_finite for side in sides],
        "outcomes": [asdict(side.outcome) for side in sides],
    }


def write_pictures(sides: tuple[Side, Side], folder: Path) -> float:
    """Writes the page's PNGs into `folder`; returns the mean FLIP difference."""
    import flip_evaluator

    a, b = (images.luminance(side.picture) for side in sides)
    scale = (a + b) / 2 + 0.1 * float((a.mean() + b.mean()) / 2)
    difference = np.divide(a - b, scale, out=np.zeros_like(a), where=scale > 0)
    agree = metrics.agreement(sides[0].halves, sides[1].halves)
    z = images.enlarge(agree.block_z.astype(np.float32), agree.block)
    flip_map, flip_mean, _ = flip_evaluator.evaluate(
        sides[1].view, sides[0].view, "LDR", inputsRGB=True, applyMagma=False
    )
    for number, side in enumerate(sides):
        images.write_png(folder / f"picture-{number}.png", side.view)
    images.write_png(folder / "difference.png", images.diverging(difference, 0.5))
    images.write_png(folder / "blocks.png", images.diverging(z, 5.0))
    images.write_png(folder / "flip.png", images.heat(np.asarray(flip_map)[:, :, 0]))
    return float(flip_mean)


def compare(options: argparse.Namespace) -> Path:
    """Does all of it; returns the page's path. Raises ToolError."""
    blend_file_there(options.scene)
    output: Path = options.output or Path("out", "compare", options.scene.stem)
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as temporary:
        sides = (
            render_side(options, 0, Path(temporary)),
            render_side(options, 1, Path(temporary)),
        )
    if sides[0].picture.shape != sides[1].picture.shape:
        raise ToolError(
            f"the pictures differ in size: {sides[0].picture.shape[:2]} and "
            f"{sides[1].picture.shape[:2]}"
        )
    numbers = figures(sides, write_pictures(sides, output))
    (output / "figures.json").write_text(json.dumps(numbers, indent=1) + "\n")
    page = output / "index.html"
    write_page(page, options.scene.name, numbers)
    ratio, error = numbers["mean_ratio"], numbers["mean_ratio_error"]
    print(
        f"mean ratio {ratio:.5f} +- {error:.5f}, worst block "
        f"{numbers['worst_block_z']:.1f} sigma (p = {numbers['worst_block_probability']:.2g}), "
        f"FLIP {numbers['flip_mean']:.4f}"
    )
    return page


def main() -> int:
    options = command_lines.compare(sys.argv[1:])

    def work() -> int:
        print(compare(options))
        return 0

    return ended(COMMAND, work)


if __name__ == "__main__":
    sys.exit(main())
