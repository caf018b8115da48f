"""Command lines of what measures and shows accuracy; see command_lines.py."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from vernier_tools import settings
from vernier_tools.arguments import (
    Parser,
    positive_float,
    positive_int,
    rising_ints,
    stopping_rules,
)
from vernier_tools.shared_options import (
    blend_scene,
    film,
    output_by_scene,
    output_folder,
    several_scenes,
)


def progress(arguments: Sequence[str]) -> argparse.Namespace:
    """Of scripts/progress."""
    parser = Parser(
        prog="scripts/progress",
        description="Shows SCENE as it refines: one render, stopped and resumed at each number of "
        "samples. Writes a page with the pictures side by side, each with its error.",
    )
    parser.add_argument("scene", type=blend_scene, metavar="SCENE.blend")
    parser.add_argument(
        "--samples",
        type=rising_ints,
        default=[8, 40, 200, 1000],
        metavar="N,...",
        help="samples per pixel of the pictures (8,40,200,1000)",
    )
    parser.add_argument(
        "--integrator", type=settings.Setting("integrator"), default="AUTO", metavar="NAME"
    )
    film(parser)
    output_by_scene(parser, "progress")
    return parser.parse_args(arguments)


def core_integrators(text: str) -> tuple[str, ...]:
    """Integrators separated by commas, as the core names them."""
    check = settings.Setting("integrator")
    return tuple(str(check(name)) for name in text.split(","))


def core_methods(parser: argparse.ArgumentParser, usual: tuple[str, ...], what: str) -> None:
    """Adds the choice of methods."""
    parser.add_argument(
        "--integrators",
        type=core_integrators,
        default=usual,
        metavar="NAME,...",
        help=f"{what} ({','.join(usual).lower()})",
    )


def small_renders(parser: argparse.ArgumentParser, runs: int, width: int) -> None:
    """Adds how many renders there are of each kind, and how large they are."""
    parser.add_argument("--runs", type=positive_int, default=runs, help=f"renders of each ({runs})")
    parser.add_argument(
        "--width", type=positive_int, default=width, help=f"of pictures, pixels ({width})"
    )
    parser.add_argument("--threads", type=positive_int, default=1, help="(1)")


def calibrate(arguments: Sequence[str]) -> argparse.Namespace:
    """Of scripts/calibrate."""
    parser = Parser(
        prog="scripts/calibrate",
        description="Are the error bars true? Renders small pictures of scenes again and again, by "
        "several methods and stopping rules, beside a long render: how many pixels lie within "
        "their stated 95 % half-width, and the picture's error as stated and as it is.",
    )
    several_scenes(parser)
    core_methods(parser, ("PATH", "BDPT"), "unbiased methods")
    parser.add_argument(
        "--rules",
        type=stopping_rules,
        default=("16", "64", "target=20", "time=1"),
        metavar="RULE,...",
        help="a number of batches, target=PERCENT or time=SECONDS (16,64,target=20,time=1)",
    )
    small_renders(parser, 8, 40)
    parser.add_argument(
        "--reference",
        type=settings.Setting("integrator"),
        default="BDPT",
        metavar="NAME",
        help="the method of the long render (bdpt)",
    )
    parser.add_argument(
        "--reference-samples", type=positive_int, default=8192, metavar="N", help="of it (8192)"
    )
    output_folder(parser, "calibrate")
    return parser.parse_args(arguments)


def methods(arguments: Sequence[str]) -> argparse.Namespace:
    """Of scripts/methods."""
    parser = Parser(
        prog="scripts/methods",
        description="Does Auto choose well, and does adaptive sampling pay? Renders small pictures "
        "of scenes, and of variations of them, by each method that Auto may choose, tells the "
        "processor time that each needs to a true error, and what Auto chose.",
    )
    several_scenes(parser)
    core_methods(parser, ("PATH", "BDPT", "MLT"), "to be measured")
    parser.add_argument(
        "--seconds", type=positive_float, default=2.0, help="of processor time a render (2)"
    )
    parser.add_argument(
        "--reference-time", type=positive_float, default=40.0, help="seconds a reference (40)"
    )
    parser.add_argument(
        "--references",
        type=core_integrators,
        default=(),
        metavar="NAME,...",
        help="methods of the reference, where some miss light (all that are measured)",
    )
    small_renders(parser, 4, 48)
    parser.add_argument(
        "--chosen-width",
        type=positive_int,
        default=160,
        help="of the picture that Auto chooses for, pixels (160)",
    )
    parser.add_argument(
        "--variations",
        action="store_true",
        help="also with lamps moved, and with rougher materials",
    )
    parser.add_argument(
        "--target",
        type=positive_float,
        metavar="PERCENT",
        help="measure adaptive sampling instead: time to this error with and without it, by path "
        "tracing",
    )
    output_folder(parser, "methods")
    return parser.parse_args(arguments)
