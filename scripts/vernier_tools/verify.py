"""Tests that all methods make the same pictures: each against another one's, block by block.

A scene is exported once and rendered small by the core, each method several times with seeds of its
own. Pieces of a run add up: its figures are kept, and the table shows all of them.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import sys
import time
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vernier_tools import command_lines, verify_statistics
from vernier_tools.errors import ToolError

if TYPE_CHECKING:
    from engine_core.description import SceneDescription

    from vernier_tools.capture import Capture

COMMAND = "scripts/verify"
#: Samples of a pixel for each that a bidirectional method takes in the same time, or has passes.
SHARE = {"path": 2.0, "light": 2.0}
#: Whose pictures others are measured by: the first that is not the method itself.
REFERENCES = ("path", "bdpt")
#: Where paths from the camera hardly find the light.
HARD_REFERENCES = {
    "caustics": ("bdpt", "vcm"),
    "door_ajar": ("bdpt", "path"),
    "lamp_interior": ("bdpt", "path"),
    "pool": ("vcm", "sppm"),
}
#: The bias that is let pass, relative to a block: light that is gathered is blurred over its edges.
BIAS = {"vcm": 0.01, "sppm": 0.02, "photon": 0.1}
#: Light that methods find by chance only, so that they may show too little of it, but no more: in
#: the pool it has passed the water twice, in the caustics the camera's paths must meet a small
#: lamp.
FOUND_BY_CHANCE = {
    "caustics": {"path"},
    "pool": {"path", "bdpt", "pssmlt", "mmlt", "mlt"},
}
#: Fewer pictures of what costs most before the first sample: each has photon maps of its own.
MOST_PICTURES = {"photon": 6}
#: Samples of the reference for each of a picture's.
REFERENCE_SHARE = 2
FIRST_REFERENCE_SEED = 1_000_001
#: Camera rays of a pixel by which it is told what paths from lights can show of it, and the least
#: squared roughness at which enough of them are seen.
SIGHT_RAYS = 64
LEAST_ROUGHNESS = 0.004


def describe(path: Path, size: tuple[int, int]) -> SceneDescription:
    """The scene as Vernier would render it. Raises ToolError."""
    import bpy

    from vernier_tools.blend_file import open_blend, require_camera
    from vernier_tools.engines import enable_cycles, register_vernier

    enable_cycles()
    register_vernier()
    scene = open_blend(path)
    require_camera(scene)
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    from addon.export import export_scene

    return export_scene(bpy.context.evaluated_depsgraph_get(), border=False)[0]


class Studio:
    """A scene, and the pictures that were made of it."""

    def __init__(self, options: argparse.Namespace, path: Path) -> None:
        import engine_core

        self.options = options
        self.name = path.stem
        self.digest = hashlib.sha256(path.read_bytes()).hexdigest()[:12]
        self.scene = engine_core.compile(describe(path, options.resolution), options.threads)
        width, height = options.resolution
        self.everywhere = np.ones((height, width), bool)
        self.notes: dict[str, list[str]] = {}

    def region(self, method: str) -> NDArray[np.bool_]:
        """The pixels that the method claims to show: paths from lights alone never meet the camera
        by way of a mirror or glass, hardly ever by what is nearly one, nor at what only the camera
        sees."""
        if method != "light":
            return self.everywhere
        from engine_core import probe

        return np.array(probe.sharpest_seen(self.scene, SIGHT_RAYS)) >= LEAST_ROUGHNESS

    def render(self, method: str, samples: int, seed: int) -> NDArray[np.float32]:
        """One picture. Raises ToolError when a sample is not finite."""
        import engine_core

        values = {"integrator": method.upper(), "samples": samples, "seed": seed}
        values["threads"] = self.options.threads
        session = engine_core.Session(self.scene, values, ["Combined"])
        session.start()
        while not session.wait(1.0):
            pass
        if session.error_message:
            raise ToolError(f"{self.name} by {method}: {session.error_message}")
        lost = session.poll().non_finite
        if lost:
            raise ToolError(f"{self.name} by {method}: {lost} samples were not finite")
        self.notes[method] = list(session.notes)
        width, height = self.options.resolution
        picture: NDArray[np.float32] = session.read("Combined", 0, 0, width, height)
        return np.asarray(picture[..., :3], np.float32)

    def pictures(self, method: str, samples: int, first_seed: int) -> NDArray[np.float32]:
        samples = max(int(samples * SHARE.get(method, 1.0)), 1)
        count = min(self.options.pictures, MOST_PICTURES.get(method, self.options.pictures))
        return np.stack([self.render(method, samples, first_seed + i) for i in range(count)])

    def reference(self, method: str) -> NDArray[np.float32]:
        """Long pictures, from the folder of references where they are there already."""
        folder: Path = self.options.references
        samples = REFERENCE_SHARE * self.options.samples
        width, height = self.options.resolution
        path = folder / (
            f"verify-{self.name}-{self.digest}-{method}-{width}x{height}"
            f"-{samples}-{self.options.pictures}.npy"
        )
        if path.exists():
            kept: NDArray[np.float32] = np.load(path)
            return kept
        made = self.pictures(method, samples, FIRST_REFERENCE_SEED)
        folder.mkdir(parents=True, exist_ok=True)
        whole = path.with_suffix(".new.npy")
        np.save(whole, made)
        whole.replace(path)
        return made


def reference_of(scene: str, method: str) -> str:
    """The method that this one is measured by."""
    return next(name for name in HARD_REFERENCES.get(scene, REFERENCES) if name != method)


def verify(studio: Studio, method: str) -> dict[str, Any]:
    """One row of figures."""
    other = reference_of(studio.name, method)
    start = time.process_time()
    masks = verify_statistics.block_masks(studio.region(method), studio.options.block)
    if not masks[-1].any():
        raise ToolError(f"{studio.name} by {method}: it claims no pixel")
    made = studio.pictures(method, studio.options.samples, studio.options.seed)
    chance = FOUND_BY_CHANCE.get(studio.name, set())
    of_method, of_reference = (
        verify_statistics.sample(pictures, masks, by_chance=name in chance)
        for name, pictures in ((method, made), (other, studio.reference(other)))
    )
    bias = sum(BIAS.get(name, 0.0) for name in (method, other))
    verdict = verify_statistics.compare(of_method, of_reference, bias)
    return {
        "scene": studio.name,
        "method": method,
        "reference": other,
        "region": float(masks[-1].mean()),
        "notes": studio.notes[method],
        "seconds": time.process_time() - start,
        "word": verdict.word,
        **asdict(verdict),
    }


def table(rows: Mapping[str, Mapping[str, Any]]) -> str:
    """Methods by column. A cell is the ratio to the reference's mean, and the word."""
    methods = [
        name for name in command_lines.VERIFIED if any(r["method"] == name for r in rows.values())
    ]
    scenes = sorted({row["scene"] for row in rows.values()})
    lines = ["| Scene | " + " | ".join(f"`{name}`" for name in methods) + " |"]
    lines.append("|---|" + "---:|" * len(methods))
    for scene in scenes:
        cells = [cell(rows.get(f"{scene} {name}")) for name in methods]
        lines.append(f"| `{scene}` | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def cell(row: Mapping[str, Any] | None) -> str:
    if row is None:
        return ""
    text = f"{row['ratio']:.3f} ± {row['ratio_error']:.3f}"
    known = f"{row['blocks'] - row['undecided']}/{row['blocks']}"
    if row["word"] == "DIFFERS":
        return f"**{text}**, {row['failed']} of {row['blocks']} differ"
    return f"{text}, {known}"


def line(row: Mapping[str, Any]) -> str:
    return (
        f"{row['scene']} {row['method']} by {row['reference']}: {row['word']}, ratio "
        f"{row['ratio']:.4f} ± {row['ratio_error']:.4f}, blocks to {100 * row['spread']:.2g} %, "
        f"worst z {row['worst']:+.1f} (p {row['probability']:.2g}), {row['undecided']} of "
        f"{row['blocks']} undecided, {row['failed']} differ, {row['seconds']:.0f} s"
    )


def run(options: argparse.Namespace, capture: Capture) -> int:
    """Returns how many methods differ. Raises ToolError."""
    figures: Path = options.output / "figures.json"
    options.output.mkdir(parents=True, exist_ok=True)
    differing = 0
    for path in options.scenes:
        studio = Studio(options, path)
        for method in options.methods:
            row = verify(studio, method)
            print(line(row), file=capture.terminal, flush=True)
            for note in row["notes"]:
                print(f"  {note}", file=capture.terminal, flush=True)
            differing += row["word"] == "DIFFERS"
            rows = json.loads(figures.read_text()) if figures.exists() else {}
            rows[f"{row['scene']} {row['method']}"] = row
            figures.write_text(json.dumps(rows, indent=1) + "\n")
    text = table(json.loads(figures.read_text()))
    (options.output / "table.md").write_text(text)
    print(text, file=capture.terminal)
    return differing


def main() -> None:
    options = command_lines.verify(sys.argv[1:])
    from vernier_tools.capture import Capture

    capture = Capture()
    code = 1
    try:
        code = 1 if run(options, capture) else 0
    except (ToolError, OSError) as error:
        capture.report(COMMAND, error)
    except KeyboardInterrupt:
        code = 130
    except Exception as error:
        capture.terminal_error.write(capture.text())
        capture.report(COMMAND, f"{type(error).__name__}: {error}")
    capture.flush()
    os._exit(code)  # Blender 4.5 hangs in the interpreter's shutdown


if __name__ == "__main__":
    main()
