"""Options that several commands take. This module, too, needs the standard library alone."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from vernier_tools.arguments import names_of, positive_float, positive_int, resolution
from vernier_tools.jobs import ENGINES

ROOT = Path(__file__).parents[2]


def default_cache() -> Path:
    """Where references are kept: `vernier/references` in the user's cache folder."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "vernier/references"


def blend_scene(name: str) -> Path:
    """A .blend file by its path, or by its name in blend_scenes/."""
    shipped = ROOT / "blend_scenes" / f"{name}.blend"
    return shipped if shipped.is_file() else Path(name)


def measuring(
    parser: argparse.ArgumentParser,
    engines: Sequence[str],
    references: Sequence[str],
    seconds: float,
) -> None:
    """Adds what commands take that measure engines against long renders; these are the defaults."""
    for name, names, what in (
        ("--engines", engines, "which to measure"),
        ("--references", references, "whose long renders make the reference"),
    ):
        parser.add_argument(
            name,
            type=names_of(ENGINES),
            default=tuple(names),
            metavar="ENGINE,...",
            help=f"{what} ({','.join(names)})",
        )
    parser.add_argument(
        "--reference-time",
        type=positive_float,
        default=seconds,
        help=f"seconds a reference ({seconds:g})",
    )
    parser.add_argument("--cache", type=Path, default=default_cache(), help="for references")
    film(parser)


def film(parser: argparse.ArgumentParser) -> None:
    """Adds threads and size."""
    parser.add_argument("--threads", type=positive_int, default=0, help="default: all")
    parser.add_argument(
        "--resolution",
        type=resolution,
        default=(0, 0),
        metavar="WxH",
        help="default: the file's own",
    )


def scenes_of(text: str) -> list[Path]:
    return [blend_scene(name) for name in text.split(",")]


def several_scenes(parser: argparse.ArgumentParser) -> None:
    """Adds the choice of scenes."""
    parser.add_argument(
        "--scenes",
        type=scenes_of,
        default=sorted((ROOT / "blend_scenes").glob("*.blend")),
        metavar="NAME,...",
        help="names in blend_scenes/, or paths (default: all of blend_scenes/)",
    )


def output_folder(parser: argparse.ArgumentParser, name: str, what: str = "") -> None:
    """Adds the folder that the command writes into, by default out/NAME."""
    default = Path("out", name)
    help_text = f"{what} ({default})" if what else f"default: {default}"
    parser.add_argument("-o", "--output", type=Path, default=default, metavar="DIR", help=help_text)


def output_by_scene(parser: argparse.ArgumentParser, name: str) -> None:
    """Adds the same, by default out/NAME/SCENE; None where it is not given."""
    parser.add_argument(
        "-o", "--output", type=Path, metavar="DIR", help=f"default: out/{name}/SCENE"
    )
