"""The project's own rules of style, checked by its own tools."""

from __future__ import annotations

import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PYTHON_FOLDERS = ["addon", "blend_scenes", "engine_core/python", "scripts", "tests"]
CPP_FOLDER = "engine_core"
MOST_LINES = 500


def run_tool(name: str, *arguments: str) -> None:
    """Runs a program of this environment and fails with what it printed."""
    program = Path(sysconfig.get_path("scripts"), name)
    done = subprocess.run([str(program), *arguments], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def sources(*suffixes: str) -> list[str]:
    """The project's files with one of the suffixes, relative to its root."""
    folders = {folder.split("/")[0] for folder in [*PYTHON_FOLDERS, CPP_FOLDER]}
    found = [
        str(path.relative_to(ROOT))
        for folder in sorted(folders)
        for path in sorted((ROOT / folder).rglob("*"))
        if path.suffix in suffixes and path.is_file()
    ]
    assert found
    return found


def test_ruff_finds_nothing() -> None:
    run_tool("ruff", "check", *PYTHON_FOLDERS)


def test_python_is_formatted() -> None:
    run_tool("ruff", "format", "--check", *PYTHON_FOLDERS)


@pytest.mark.skipif(
    sys.version_info < (3, 13), reason="once is enough: mypy checks for Python 3.11"
)
def test_types_are_right() -> None:
    run_tool("mypy", "addon", "engine_core/python/engine_core", "scripts/vernier_tools")


def test_cpp_is_formatted() -> None:
    run_tool("clang-format", "--dry-run", "--Werror", *sources(".h", ".cpp"))


def test_no_file_is_longer_than_can_be_read() -> None:
    lines = {
        name: len((ROOT / name).read_text(encoding="utf-8").splitlines())
        for name in sources(".py", ".h", ".cpp", ".sh")
    }
    assert not {name: count for name, count in lines.items() if count > MOST_LINES}
