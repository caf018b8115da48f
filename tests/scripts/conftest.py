"""Makes the tools importable, however pytest was started."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from tool_process import ROOT, Tool

sys.path[:0] = [str(ROOT / "scripts"), str(ROOT)]
# The processes that the tools start must find them too.
os.environ["PYTHONPATH"] = os.pathsep.join(
    [str(ROOT / "scripts"), str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
)


@pytest.fixture
def tool(tmp_path: Path) -> Tool:
    """Runs a module of the tools in the test's own empty folder."""

    def run(module: str, *arguments: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", f"vernier_tools.{module}", *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)

    return run
