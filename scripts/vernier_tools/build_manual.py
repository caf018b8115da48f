"""Builds the manual's generated parts in docs/manual: the tables of settings and nodes from the
core's own tables, the pictures by rendering, and the measured trade between the methods."""

from __future__ import annotations

import argparse
import math
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import OpenImageIO

from vernier_tools import jobs
from vernier_tools.errors import ToolError, ended, say
from vernier_tools.images import read_combined
from vernier_tools.manual_tables import nodes_page, settings_page
from vernier_tools.metrics import relative_squared_error

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "manual"
COMMAND = "scripts/build_manual"


@dataclass(frozen=True)
class Picture:
    scene: str
    method: str
    seconds: float = 60.0
    #: What the file's name tells besides, and the settings that it stands for.
    kind: str = ""
    settings: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        return "_".join(filter(None, (self.scene, self.method, self.kind)))


CYCLES = "cycles"
FEW, MANY = 1_000, 30_000
PICTURES = (
    Picture("cornell_box", "path"),
    Picture("textured_room", "path", 90.0),
    Picture("caustics", "path"),
    Picture("caustics", "bdpt"),
    Picture("lamp_interior", "path"),
    Picture("lamp_interior", "bdpt"),
    Picture("pool", "bdpt"),
    Picture("pool", "vcm"),
    Picture("door_ajar", "mlt"),
    *(Picture(scene, CYCLES) for scene in ("door_ajar", "lamp_interior", "pool")),
    *(
        Picture("caustics", "photon", 120.0, kind,
                (f"global_photons={photons}", f"caustic_photons={photons}"))
        for kind, photons in (("few", FEW), ("many", MANY))
    ),
    Picture("caustics", "photon", 20.0, "shown", ("photon_view=CAUSTIC", "caustic_photons=20000")),
)  # fmt: skip
PICTURE_SIZE = (480, 300)

# The measured trade: scenes and methods at equal time, against long renders by the last method.
SCENES = ("cornell_box", "veach_plates", "lamp_interior", "caustics")
METHODS = ("path", "light", "bdpt")
MEASURED_SIZE = (240, 150)


def size_text(size: tuple[int, int]) -> str:
    return "{}x{}".format(*size)


def render(
    scene: str,
    method: str,
    target: Path,
    size: tuple[int, int],
    seconds: float,
    seed: int = 0,
    settings: tuple[str, ...] = (),
) -> None:
    """Renders one scene in a process of its own. Raises ToolError."""
    command = [sys.executable, "-m", "vernier_tools.render"]
    command += [str(ROOT / "blend_scenes" / f"{scene}.blend"), "-o", str(target)]
    command += ["--integrator", method, "--time", str(seconds), "--seed", str(seed)]
    command += ["--resolution", size_text(size)]
    for setting in settings:
        command += ["--set", setting]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise ToolError(f"{scene} by {method}: {done.stderr.strip()[-300:]}")


def render_by_cycles(
    scene: str, target: Path, size: tuple[int, int], seconds: float, scratch: Path
) -> None:
    """Likewise, without what biases Cycles. Raises ToolError."""
    output = scratch / scene
    blend = str(ROOT / "blend_scenes" / f"{scene}.blend")
    jobs.run(jobs.Job(CYCLES, blend, str(output), time=seconds, resolution=size, view=True))
    OpenImageIO.ImageBuf(f"{output}-0.png").write(str(target))


def write_pictures(pictures: Iterable[Picture], share: float) -> None:
    folder = FOLDER / "pictures"
    folder.mkdir(exist_ok=True)
    for picture in pictures:
        say(COMMAND, f"picture {picture.name}")
        target = folder / f"{picture.name}.jpg"
        seconds = share * picture.seconds
        if picture.method == CYCLES:
            with tempfile.TemporaryDirectory() as scratch:
                render_by_cycles(picture.scene, target, PICTURE_SIZE, seconds, Path(scratch))
        else:
            render(
                picture.scene,
                picture.method,
                target,
                PICTURE_SIZE,
                seconds,
                settings=picture.settings,
            )


def pictures_named(text: str) -> list[Picture]:
    known = {picture.name: picture for picture in PICTURES}
    names = text.split(",")
    for name in names:
        if name not in known:
            raise argparse.ArgumentTypeError(f"{name!r}: choose from {', '.join(known)}")
    return [known[name] for name in names]


def write_measurements(seconds: float, reference_seconds: float) -> None:
    """Error at equal time: the root of the mean relative squared error."""
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        for scene in SCENES:
            say(COMMAND, f"measuring {scene}")
            reference = Path(scratch, f"{scene}.exr")
            render(scene, METHODS[-1], reference, MEASURED_SIZE, reference_seconds, seed=1)
            truth = read_combined(reference)
            cells = []
            for method in METHODS:
                target = Path(scratch, f"{scene}_{method}.exr")
                render(scene, method, target, MEASURED_SIZE, seconds)
                error = math.sqrt(relative_squared_error(read_combined(target), truth))
                cells.append(f"{100.0 * error:.{0 if error >= 0.095 else 1}f} %")
            rows.append(f"| `{scene}` | " + " | ".join(cells) + " |")
    heads = " | ".join(f"`{method}`" for method in METHODS)
    text = f"""# The trade, measured

Error after {seconds:g} seconds at {size_text(MEASURED_SIZE)} pixels on the machine that built \
this page, all its threads: the root of the mean squared error relative to each pixel (or to 10 % \
of the mean, where that is more), against {reference_seconds:g} seconds of `{METHODS[-1]}`. Less \
is better; half the error would take four times as long. An error that does not shrink with time \
is light that the method cannot find.

| Scene | {heads} |
|---|{"---|" * len(METHODS)}
""" + "\n".join(rows)
    (FOLDER / "measured.md").write_text(text + "\n")


def main() -> int:
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--tables", action="store_true", help="the tables only, at once")
    parser.add_argument(
        "--pictures",
        type=pictures_named,
        metavar="NAME,...",
        help="the tables and these pictures only",
    )
    parser.add_argument("--seconds", type=float, default=20.0, help="for each measured render (20)")
    parser.add_argument(
        "--reference-seconds", type=float, default=600.0, help="for each reference (600)"
    )
    parser.add_argument(
        "--picture-share", type=float, default=1.0, help="of the pictures' usual time (1)"
    )
    options = parser.parse_args()

    def work() -> int:
        FOLDER.mkdir(parents=True, exist_ok=True)
        (FOLDER / "settings.md").write_text(settings_page())
        (FOLDER / "nodes.md").write_text(nodes_page())
        if options.pictures:
            write_pictures(options.pictures, options.picture_share)
        elif not options.tables:
            write_pictures(PICTURES, options.picture_share)
            write_measurements(options.seconds, options.reference_seconds)
        return 0

    return ended(COMMAND, work)


if __name__ == "__main__":
    sys.exit(main())
