"""What the commands take on their command lines.

`environment.sh` also runs this module with a bare interpreter, to answer `--help` before anything
is installed: it needs the standard library alone, and of the core only where there is one.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from vernier_tools import accuracy_lines, settings
from vernier_tools.arguments import (
    Parser,
    frame_range,
    names_of,
    positive_float,
    positive_int,
    positive_numbers,
    resolution,
)
from vernier_tools.jobs import ENGINES, USUAL_ENGINES
from vernier_tools.shared_options import (
    ROOT,
    blend_scene,
    default_cache,
    film,
    measuring,
    output_by_scene,
    output_folder,
    several_scenes,
)

BENCHMARK_PARTS = ("scenes", "rays", "photons", "sizes")
USUAL_PARTS = ("scenes", "rays", "sizes")
#: The methods that go to the same picture.
VERIFIED = ("path", "light", "bdpt", "pssmlt", "mmlt", "mlt", "vcm", "sppm", "photon")


def render(arguments: Sequence[str]) -> argparse.Namespace:
    """Of scripts/render."""
    parser = Parser(
        prog="scripts/render",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Renders SCENE.blend with Vernier. What is not said is as the file has it.",
        epilog=settings.describe(),
    )
    parser.add_argument("scene", type=Path, metavar="SCENE.blend")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="OUT",
        help=".exr: linear, 32-bit float, with the passes; .png, .tif, .jpg: as Blender shows the "
        "picture. With --frames, #### in the name stands for the frame's number",
    )
    parser.add_argument(
        "--integrator",
        type=settings.Setting("integrator"),
        metavar="NAME",
        help="the method that renders; see the settings below",
    )
    parser.add_argument(
        "--samples", type=settings.Setting("samples"), metavar="N", help="samples per pixel"
    )
    parser.add_argument(
        "--time",
        type=settings.Setting("time_limit"),
        metavar="SECONDS",
        help="time limit; without --samples, the time alone ends the render",
    )
    parser.add_argument(
        "--target-error",
        type=settings.Setting("target_error"),
        metavar="PERCENT",
        help="stop at this error of the picture; without --samples, nothing but it and --time ends "
        "the render",
    )
    parser.add_argument(
        "--checkpoint",
        type=Path,
        metavar="FILE",
        help="keep the render's state in FILE: every minute, in the end, and when interrupted",
    )
    parser.add_argument(
        "--resume",
        action="store_true",
        help="go on from the state in the --checkpoint file, to other samples, time or target; "
        "where there is none yet, begin",
    )
    parser.add_argument(
        "--seed", type=settings.Setting("seed"), metavar="N", help="of the random numbers"
    )
    parser.add_argument(
        "--threads", type=positive_int, metavar="N", help="default: as the file says"
    )
    parser.add_argument("--resolution", type=resolution, metavar="WxH", help="in pixels")
    frames = parser.add_mutually_exclusive_group()
    frames.add_argument("--frame", type=int, metavar="N", help="default: the file's current frame")
    frames.add_argument("--frames", type=frame_range, metavar="A-B", help="both included")
    parser.add_argument(
        "--set",
        dest="assignments",
        action="append",
        default=[],
        type=settings.assignment,
        metavar="KEY=VALUE",
        help="any setting of the engine (listed below); may be repeated",
    )
    options = parser.parse_args(arguments)
    if options.resume and options.checkpoint is None:
        parser.error("--resume needs --checkpoint FILE")
    if options.checkpoint is not None and options.frames:
        parser.error("--checkpoint is for one frame")
    return options


def compare(arguments: Sequence[str]) -> argparse.Namespace:
    """Of scripts/compare_cycles."""
    parser = Parser(
        prog="scripts/compare_cycles",
        description="Renders SCENE with Vernier and with Cycles under equal settings (Cycles' "
        "biases off) and writes a page with both pictures, their difference and the figures. Each "
        "engine renders two independent halves, so that the page can tell noise from disagreement.",
    )
    parser.add_argument("scene", type=Path, metavar="SCENE.blend")
    limit = parser.add_mutually_exclusive_group()
    limit.add_argument("--samples", type=positive_int, help="samples per pixel (default 256)")
    limit.add_argument("--time", type=positive_float, help="seconds of rendering for each engine")
    parser.add_argument("--seed", type=int, default=0)
    film(parser)
    parser.add_argument(
        "--engines",
        type=names_of(ENGINES),
        default=USUAL_ENGINES,
        metavar="A,B",
        help="the two to compare (default vernier,cycles); cycles,cycles shows what noise alone "
        "does",
    )
    output_by_scene(parser, "compare")
    options = parser.parse_args(arguments)
    if len(options.engines) != 2:
        parser.error("argument --engines takes two of " + ", ".join(ENGINES))
    return options


def benchmark(arguments: Sequence[str]) -> argparse.Namespace:
    """Of scripts/benchmark."""
    parser = Parser(
        prog="scripts/benchmark",
        description="Measures Vernier beside Cycles. Part scenes: samples per second of processor "
        "time, error at equal time, time to the first tile, memory. Part rays: Vernier's rays per "
        "second beside Embree's own, on the same rays. Part sizes: export, build and memory of "
        "generated scenes. Part photons, on demand: photon maps beside camera paths. Each render "
        "has a process of its own, and the engines take turns.",
    )
    several_scenes(parser)
    parser.add_argument(
        "--parts",
        type=names_of(BENCHMARK_PARTS),
        default=USUAL_PARTS,
        metavar="PART,...",
        help="default: " + ",".join(USUAL_PARTS),
    )
    parser.add_argument("--time", type=positive_float, default=8.0, help="seconds a render (8)")
    parser.add_argument("--repeats", type=positive_int, default=3, help="renders an engine (3)")
    measuring(parser, USUAL_ENGINES, USUAL_ENGINES, 120.0)
    parser.add_argument(
        "--triangles",
        type=positive_numbers,
        default=[1.0, 4.0, 16.0],
        metavar="N,...",
        help="sizes of the generated scenes, in millions (1,4,16)",
    )
    parser.add_argument(
        "--photons",
        type=positive_float,
        default=1.0,
        metavar="N",
        help="of the photon maps that are measured, in millions (1)",
    )
    output_folder(parser, "benchmark")
    return parser.parse_args(arguments)


def extremes(arguments: Sequence[str]) -> argparse.Namespace:
    """Of scripts/extremes."""
    parser = Parser(
        prog="scripts/extremes",
        description="Renders every case of the suite of extremes by every method, judges what each "
        "must show, and writes a table and pictures of the farthest off.",
    )
    parser.add_argument(
        "--only", default="", metavar="TEXT", help="cases whose title and method hold this text"
    )
    parser.add_argument(
        "--methods", type=lambda text: text.split(","), metavar="A,B", help="default: all"
    )
    parser.add_argument(
        "--share", type=positive_float, default=2.0, help="of the cases' usual samples (2)"
    )
    parser.add_argument(
        "--pictures",
        type=positive_int,
        default=16,
        help="independent ones (16): fewer tell little of a whole picture's own error",
    )
    parser.add_argument("--quick", action="store_true", help="without large cases and long paths")
    parser.add_argument(
        "--resume",
        action="store_true",
        help="go on with results.csv of the output's folder: what it has is not rendered again",
    )
    parser.add_argument(
        "--time", type=positive_float, metavar="SECONDS", help="after these, write what there is"
    )
    output_folder(parser, "extremes")
    return parser.parse_args(arguments)


def sanitize(arguments: Sequence[str]) -> argparse.Namespace:
    """Of scripts/sanitize."""
    parser = Parser(
        prog="scripts/sanitize",
        description="Builds the core with the compiler's sanitizers (into build/sanitizers) and "
        "runs it for long: `files` fuzzes saved scenes, guided by what they make run, and "
        "`descriptions` renders generated ones, under the address and undefined-behaviour "
        "sanitizers; `threads` renders by every method under the thread sanitizer.",
    )
    parser.add_argument("part", choices=("files", "descriptions", "threads"))
    parser.add_argument(
        "--minutes", type=positive_float, default=10.0, help="of files, descriptions (10)"
    )
    parser.add_argument("--seed", type=positive_int, default=1)
    parser.add_argument("--build", type=Path, metavar="DIR", help="another folder for the build")
    output_folder(parser, "sanitize", "where a file at fault is left")
    return parser.parse_args(arguments)


def tradeoff(arguments: Sequence[str]) -> argparse.Namespace:
    """Of scripts/tradeoff."""
    parser = Parser(
        prog="scripts/tradeoff",
        description="Measures error against time of Vernier's methods and of Cycles on SCENE, "
        "under equal settings: curves with fitted slopes, time to 10, 5, 2 and 1 % error, bias of "
        "the mean, FLIP, memory, pictures at equal time. Prints a table and writes a page.",
    )
    parser.add_argument("scene", type=blend_scene, metavar="SCENE.blend")
    parser.add_argument(
        "--budgets",
        type=positive_numbers,
        default=[1.0, 2.0, 4.0, 8.0, 16.0],
        metavar="S,...",
        help="seconds of the renders (1,2,4,8,16)",
    )
    parser.add_argument("--repeats", type=positive_int, default=2, help="renders of each (2)")
    measuring(parser, tuple(ENGINES), ("vernier-bdpt",), 240.0)
    output_by_scene(parser, "tradeoff")
    return parser.parse_args(arguments)


def verify(arguments: Sequence[str]) -> argparse.Namespace:
    """Of scripts/verify."""
    parser = Parser(
        prog="scripts/verify",
        description="Tests that all methods make the same pictures: renders each scene small by "
        "each method, several times, and compares means and blocks of pixels with another method's "
        "by Welch's test. Prints a table; ends with 1 where two differ. What rare bright values "
        "carry is told to be undecided.",
    )
    parser.add_argument(
        "scenes",
        nargs="*",
        type=blend_scene,
        metavar="SCENE",
        help="names in blend_scenes/, or paths (default: all of blend_scenes/)",
    )
    parser.add_argument(
        "--methods",
        type=names_of(VERIFIED),
        default=VERIFIED,
        metavar="METHOD,...",
        help="default: " + ",".join(VERIFIED),
    )
    parser.add_argument("--samples", type=positive_int, default=32, help="of a picture (32)")
    parser.add_argument("--pictures", type=positive_int, default=16, help="independent ones (16)")
    parser.add_argument("--seed", type=positive_int, default=1, help="of the first picture (1)")
    parser.add_argument("--block", type=positive_int, default=16, help="its side in pixels (16)")
    parser.add_argument("--threads", type=positive_int, default=0, help="default: all")
    parser.add_argument("--resolution", type=resolution, default=(64, 48), metavar="WxH")
    parser.add_argument(
        "--references", type=Path, default=default_cache(), metavar="DIR", help="keep them there"
    )
    output_folder(parser, "verify", "where figures add up (default: %(default)s)")
    options = parser.parse_args(arguments)
    if options.pictures < 4:
        parser.error("argument --pictures: a variance takes 4 at least")
    options.scenes = options.scenes or sorted((ROOT / "blend_scenes").glob("*.blend"))
    return options


COMMANDS: dict[str, Callable[[Sequence[str]], argparse.Namespace]] = {
    "render": render,
    "compare": compare,
    "benchmark": benchmark,
    "extremes": extremes,
    "sanitize": sanitize,
    "tradeoff": tradeoff,
    "verify": verify,
    "progress_page": accuracy_lines.progress,
    "calibrate": accuracy_lines.calibrate,
    "methods": accuracy_lines.methods,
}

if __name__ == "__main__":
    COMMANDS[sys.argv[1]](sys.argv[2:])
