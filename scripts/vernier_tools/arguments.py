"""Types of command line arguments; each raises ArgumentTypeError with a message for argparse."""

from __future__ import annotations

import argparse
import itertools
import math
import re
from collections.abc import Callable, Iterable
from typing import NoReturn


def positive_int(text: str) -> int:
    if not re.fullmatch(r"\d{1,9}", text) or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive whole number")
    return int(text)


def positive_float(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (value > 0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number")
    return value


def resolution(text: str) -> tuple[int, int]:
    """WIDTHxHEIGHT in pixels, each from 4 to 65536 as Blender allows."""
    found = re.fullmatch(r"(\d{1,6})[xX](\d{1,6})", text)
    size = (int(found[1]), int(found[2])) if found else (0, 0)
    if not all(4 <= n <= 65536 for n in size):
        raise argparse.ArgumentTypeError(f"{text!r} is not WIDTHxHEIGHT, each from 4 to 65536")
    return size


def frame_range(text: str) -> range:
    """A-B, both included, as a range."""
    found = re.fullmatch(r"(-?\d{1,7})-(-?\d{1,7})", text)
    if not found or int(found[1]) > int(found[2]):
        raise argparse.ArgumentTypeError(f"{text!r} is not FIRST-LAST")
    return range(int(found[1]), int(found[2]) + 1)


def positive_numbers(text: str) -> list[float]:
    """Positive numbers separated by commas."""
    return [positive_float(part) for part in text.split(",")]


def rising_ints(text: str) -> list[int]:
    """Positive whole numbers, each larger than the one before, separated by commas."""
    numbers = [positive_int(part) for part in text.split(",")]
    if any(b <= a for a, b in itertools.pairwise(numbers)):
        raise argparse.ArgumentTypeError(f"{text!r} is not in rising order")
    return numbers


def stopping_rules(text: str) -> tuple[str, ...]:
    """When renders stop: numbers of batches, `target=PERCENT`, `time=SECONDS`."""
    rules = tuple(text.split(","))
    for rule in rules:
        name, equals, value = rule.partition("=")
        if not equals:
            positive_int(rule)
        elif name in ("target", "time"):
            positive_float(value)
        else:
            raise argparse.ArgumentTypeError(f"{rule!r} is not target=PERCENT or time=SECONDS")
    return rules


def names_of(known: Iterable[str]) -> Callable[[str], tuple[str, ...]]:
    """The type of a list of some of the known names, separated by commas."""

    def names(text: str) -> tuple[str, ...]:
        chosen = tuple(text.split(","))
        if not set(chosen) <= set(known):
            raise argparse.ArgumentTypeError(f"{text!r}: choose from {', '.join(known)}")
        return chosen

    return names


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line: no usage is printed before them."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: error: {message}\n")
