"""What the tests of the tools share."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parents[2]
CORNELL_BOX = ROOT / "blend_scenes" / "cornell_box.blend"

#: `tool("render", "a.blend", "-o", "b.png")` runs a module of the tools in an empty folder.
Tool = Callable[..., subprocess.CompletedProcess[str]]
