"""The test of the methods against each other: its arithmetic, its table, and a short run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from tool_process import CORNELL_BOX, Tool
from vernier_tools import verify, verify_statistics
from vernier_tools.verify_statistics import Verdict

Pictures = NDArray[np.float32]

SHAPE = (16, 32, 48, 3)
EVERYWHERE = np.ones(SHAPE[1:3], bool)


def noisy(seed: int, mean: float = 1.0) -> Pictures:
    """Of gamma-distributed noise, as light's is: skew, with all moments."""
    return np.random.default_rng(seed).gamma(2.0, mean / 2.0, SHAPE).astype(np.float32)


def rare(seed: int, chance: float) -> Pictures:
    """Of mean 2, of which a half is in values that come with this chance and are as large."""
    rng = np.random.default_rng(seed)
    # The chance itself varies over many scales, as that of paths that only chance finds does.
    odds = chance * 10 ** rng.uniform(-3, 3, SHAPE[:3])
    found = rng.uniform(size=SHAPE[:3]) < odds
    return np.asarray(noisy(seed + 1) + (found / odds)[..., None], np.float32)


def verdict(a: Pictures, b: Pictures, bias: float = 0.0) -> Verdict:
    masks = verify_statistics.block_masks(EVERYWHERE, 16)
    return verify_statistics.compare(
        verify_statistics.sample(a, masks), verify_statistics.sample(b, masks), bias
    )


def test_equal_means_agree() -> None:
    found = [verdict(noisy(i), noisy(100 + i)) for i in range(30)]
    assert all(v.word == "agrees" and v.undecided == 0 for v in found)
    # The chance of the worst block is evenly distributed.
    chances = np.sort([v.probability for v in found])
    assert 0.3 < chances.mean() < 0.7


def test_blocks_and_colours_that_differ_are_found() -> None:
    picture = noisy(1)
    picture[:, 16:32, 16:32, 2] *= 1.2
    found = verdict(picture, noisy(2))
    assert (found.word, found.failed, found.blocks) == ("DIFFERS", 1, 7)
    assert found.worst > 5
    assert found.ratio == pytest.approx(1 + 0.2 / 18, abs=0.01)
    picture = noisy(3, 0.9)
    assert verdict(picture, noisy(4)).failed == 7
    assert verdict(picture, noisy(4)).worst < -5


def test_a_stated_bias_is_let_pass_and_no_more() -> None:
    picture, other = noisy(5, 1.05), noisy(6)
    assert verdict(picture, other).failed
    assert verdict(picture, other, bias=0.06).word == "agrees"
    assert verdict(noisy(7, 1.2), other, bias=0.06).failed


def test_what_few_values_carry_is_undecided() -> None:
    whole = noisy(8, 2.0)
    # Half of the light has hardly been found yet: that is no proof that it is missing,
    found = verdict(rare(9, 1e-4), whole)
    assert found.word == "undecided"
    # nor is it one that others have more of it.
    assert verdict(whole, rare(9, 1e-4)).word == "undecided"
    # But what is too bright without any rare value is wrong.
    assert verdict(3 * whole, rare(9, 1e-4)).word == "undecided"
    assert verdict(rare(9, 1e-4) + 4, whole).word == "DIFFERS"


def test_the_tail_of_a_pareto_distribution() -> None:
    rng = np.random.default_rng(10)
    for shape in (0.1, 0.5, 0.9):
        values = rng.pareto(1 / shape, 20000)
        assert verify_statistics.tail_shape(values) == pytest.approx(shape, abs=0.15)
    assert verify_statistics.tail_shape(rng.uniform(size=20000)) < 0.0
    assert verify_statistics.tail_shape(np.zeros(100)) == 0.0


def test_blocks_are_cut_to_the_region() -> None:
    region = np.zeros((20, 32), bool)
    region[:16, :16] = region[:2, 16:] = region[16:, 16:] = True
    masks = verify_statistics.block_masks(region, 16)
    assert [int(mask.sum()) for mask in masks] == [256, 64, int(region.sum())]


def test_nobody_is_his_own_reference() -> None:
    for scene in ("cornell_box", "pool", "caustics"):
        for method in ("path", "bdpt", "vcm", "sppm"):
            assert verify.reference_of(scene, method) != method


def test_a_short_run_adds_up(tool: Tool, tmp_path: Path) -> None:
    command = [CORNELL_BOX, "--samples", "1", "--pictures", "6", "--resolution", "32x32"]
    command += ["--references", tmp_path / "references", "-o", tmp_path / "out", "--methods"]
    for method in ("light", "bdpt"):
        done = tool("verify", *command, method)
        assert done.returncode == 0, done.stderr
        assert f"cornell_box {method} by path: " in done.stdout
    assert "| Scene | `light` | `bdpt` |" in done.stdout
    rows = json.loads((tmp_path / "out" / "figures.json").read_text())
    assert rows.keys() == {"cornell_box light", "cornell_box bdpt"}
    assert all(row["failed"] == 0 and row["blocks"] == 5 for row in rows.values())
    assert len(list((tmp_path / "references").iterdir())) == 1
