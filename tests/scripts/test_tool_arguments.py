"""Arguments, file names and the progress line."""

from __future__ import annotations

import argparse
import io
from collections.abc import Callable

import pytest
from vernier_tools import arguments
from vernier_tools.progress import ProgressLine


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        (arguments.positive_int, "64", 64),
        (arguments.positive_float, "0.5", 0.5),
        (arguments.resolution, "1920x1080", (1920, 1080)),
        (arguments.frame_range, "3-5", range(3, 6)),
        (arguments.frame_range, "-2--1", range(-2, 0)),
    ],
)
def test_good_values(kind: Callable[[str], object], text: str, value: object) -> None:
    assert kind(text) == value


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        (arguments.positive_int, "0"),
        (arguments.positive_int, "-3"),
        (arguments.positive_int, "1e3"),
        (arguments.positive_int, "9" * 40),
        (arguments.positive_float, "nan"),
        (arguments.positive_float, "inf"),
        (arguments.positive_float, "0"),
        (arguments.positive_float, "soon"),
        (arguments.resolution, "1920"),
        (arguments.resolution, "0x10"),
        (arguments.resolution, "10x99999"),
        (arguments.resolution, "10x10x10"),
        (arguments.frame_range, "5-3"),
        (arguments.frame_range, "all"),
    ],
)
def test_bad_values_are_told(kind: Callable[[str], object], text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="is not"):
        kind(text)


def test_a_bad_option_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    parser = arguments.Parser(prog="scripts/render")
    with pytest.raises(SystemExit) as ended:
        parser.parse_args(["--nonsense"])
    assert ended.value.code == 2
    assert capsys.readouterr().err == (
        "scripts/render: error: unrecognized arguments: --nonsense\n"
    )


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True

    def fileno(self) -> int:
        raise OSError


def test_progress_on_a_terminal_stays_on_one_line() -> None:
    stream = Terminal()
    line = ProgressLine(stream)
    line.show("Sample 1/10 | Remaining 00:09")
    line.last_time -= 1
    line.show("Sample 2/10")
    line.clear()
    text = stream.getvalue()
    assert "\n" not in text
    # Shorter text covers the longer text before it, and the end wipes all.
    assert "\rSample 2/10" + " " * 18 in text
    assert text.endswith("\r" + " " * 11 + "\r")


def test_progress_elsewhere_is_lines_that_are_not_too_many() -> None:
    stream = io.StringIO()
    line = ProgressLine(stream)
    for sample in range(1000):
        line.show(f"Sample {sample}")
    line.clear()
    assert stream.getvalue() == "Sample 0\n"


def test_progress_survives_a_closed_reader() -> None:
    class Closed(io.StringIO):
        def write(self, _text: str) -> int:
            raise BrokenPipeError

    line = ProgressLine(Closed())
    line.show("Sample 1")
    assert line.interval == float("inf")
