"""Makes the tools importable, however pytest was started."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT)]
# The processes that the tools start must find them too.
os.environ["PYTHONPATH"] = os.pathsep.join(
    [str(ROOT / "scripts"), str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
)

CORNELL_BOX = ROOT / "blend_scenes" / "cornell_box.blend"

Tool = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def tool(tmp_path: Path) -> Tool:
    """Runs a module of the tools in an empty folder: `tool("render", "a.blend", "-o", "b.png")`."""

    def run(module: str, *arguments: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", f"vernier_tools.{module}", *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)

    return run
