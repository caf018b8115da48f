"""The project's own rules of style, checked by its own tools."""

from __future__ import annotations

import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PYTHON_FOLDERS = ["addon", "blend_scenes", "engine_core/python", "scripts", "tests"]
CODE_SUFFIXES = {".py", ".h", ".cpp", ".sh"}
MOST_LINES = 500


def run_tool(name: str, *arguments: str) -> None:
    """Runs a program of this environment and fails with what it printed."""
    program = Path(sysconfig.get_path("scripts"), name)
    if not program.exists():
        pytest.skip(f"{name} is not installed in this environment")
    done = subprocess.run([str(program), *arguments], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def sources(*suffixes: str) -> list[Path]:
    """The files of the repository with one of the suffixes."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode != 0:
        pytest.skip("this is no Git checkout")
    files = (ROOT / name for name in listed.stdout.splitlines())
    return [path for path in files if path.suffix in suffixes and path.exists()]


def test_ruff_finds_nothing() -> None:
    run_tool("ruff", "check", *PYTHON_FOLDERS)


def test_python_is_formatted() -> None:
    run_tool("ruff", "format", "--check", *PYTHON_FOLDERS)


@pytest.mark.skipif(sys.version_info < (3, 13), reason="once is enough: types do not depend on it")
def test_types_are_right() -> None:
    run_tool("mypy", "addon", "engine_core/python/engine_core", "scripts/vernier_tools")


def test_cpp_is_formatted() -> None:
    files = [str(path.relative_to(ROOT)) for path in sources(".h", ".cpp")]
    assert files
    run_tool("clang-format", "--dry-run", "-Werror", *files)


def test_no_file_is_longer_than_can_be_read() -> None:
    long = {
        str(path.relative_to(ROOT)): count
        for path in sources(*CODE_SUFFIXES)
        if (count := len(path.read_text(encoding="utf-8").splitlines())) > MOST_LINES
    }
    assert not long
