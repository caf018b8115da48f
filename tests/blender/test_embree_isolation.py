"""Blender's Embree and ours in one process: both loaded, and both engines' pictures right."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# Cycles, Vernier, Cycles again; the libraries are looked at while both are loaded.
PROGRAM = """
import os, sys, tempfile
sys.path[:0] = [{root!r}, {support!r}]
import numpy as np
import cycles_pairs
bpy = cycles_pairs.start()
import light_pairs
from light_cases import CASES
scene = light_pairs.plain(bpy)
CASES["area_square"](scene)
cycles_pairs.set_up(scene, 24, 24, 32)

def means(engine):
    cycles_pairs.ENGINES = (engine,)
    picture = cycles_pairs.render(scene, 1)[engine][0]
    return picture

first = means("CYCLES")
ours = means("VERNIER")
second = means("CYCLES")
ours_again = means("VERNIER")
assert np.array_equal(first, second), "Cycles renders otherwise once Vernier has"
assert np.array_equal(ours, ours_again)
assert abs(ours.mean() / first.mean() - 1.0) < 0.02, (ours.mean(), first.mean())
if os.path.exists("/proc/self/maps"):
    with open("/proc/self/maps") as maps:
        paths = {{line.split(maxsplit=5)[5].strip() for line in maps if "libembree4" in line}}
    from_wheel = {{p for p in paths if "embreex" in p}}
    assert len(from_wheel) == 1, paths
    assert paths - from_wheel, paths
print("isolated", flush=True)
os._exit(0)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks at /proc/self/maps")
def test_both_embrees_live_in_one_process() -> None:
    program = PROGRAM.format(root=str(ROOT), support=str(ROOT / "tests" / "support"))
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout.splitlines()[-1] == "isolated"
