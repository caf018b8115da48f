"""Settings on Blender's command line."""

from __future__ import annotations

import pytest

import engine_core
from addon.command_line import OptionError, overrides

TABLE = engine_core.parameters()


def given(*words: str) -> dict[str, object]:
    return dict(overrides(TABLE, ["blender", "-b", "x.blend", "--vernier-seed", "9", *words]))


def test_only_what_follows_the_dashes_counts() -> None:
    assert given() == {}
    assert given("--") == {}
    assert given("--", "--vernier-seed", "3") == {"seed": 3}


def test_both_spellings_and_the_short_name() -> None:
    words = ["--", "--vernier-time=2.5", "--vernier-max-bounces", "-1", "--vernier-samples", "7"]
    assert given(*words) == {"time_limit": 2.5, "max_bounces": -1, "samples": 7}
    assert given("--", "--vernier-integrator", "path") == {"integrator": "PATH"}


def test_words_of_others_are_passed_over() -> None:
    assert given("--", "other", "--else", "1", "--vernier-seed=2", "--more") == {"seed": 2}


@pytest.mark.parametrize("parameter", TABLE, ids=lambda parameter: parameter.name)
def test_every_setting_is_an_option(parameter: engine_core.Parameter) -> None:
    option = "--vernier-" + parameter.name.replace("_", "-")
    value = given("--", option, str(parameter.default))[parameter.name]
    assert value == parameter.default
    assert type(value) is type(parameter.default)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--vernier-seed"], "--vernier-seed: a value is missing"),
        (["--vernier-sed", "1"], "there is no option --vernier-sed; there are --vernier-"),
        (["--vernier-samples", "0"], "'0' is not a whole number from 1 to"),
        (["--vernier-samples", "1.5"], "'1.5' is not a whole number"),
        (["--vernier-time", "nan"], "'nan' is not a number from 0 to"),
        (["--vernier-integrator", "x"], "'x' is not one of path"),
    ],
)
def test_mistakes_are_named(words: list[str], sentence: str) -> None:
    with pytest.raises(OptionError) as caught:
        given("--", *words)
    assert sentence in str(caught.value)
