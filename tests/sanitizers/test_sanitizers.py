"""The core, built with sanitizers, renders and meets bad input without a report.

`scripts/sanitize` looks for longer, and for races of threads.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from vernier_tools import sanitized_build
from vernier_tools.errors import ToolError
from vernier_tools.sanitized_build import MEMORY, run

pytestmark = pytest.mark.skipif(
    sys.version_info < (3, 13), reason="once is enough: the core does not depend on it"
)


@pytest.fixture(scope="session")
def package() -> Path:
    """A folder to put on Python's path, with the core built with sanitizers."""
    try:
        sanitized_build.libraries(MEMORY)
    except ToolError as error:
        pytest.skip(str(error))
    return sanitized_build.build(MEMORY)


@pytest.fixture(scope="session")
def sanitized(package: Path) -> dict[str, str]:
    """Environment variables of a process that uses the core with sanitizers."""
    return sanitized_build.environment(MEMORY, package)


def test_the_sanitizers_are_at_work(sanitized: dict[str, str], package: Path) -> None:
    """Otherwise the other tests would show nothing."""
    code = "import engine_core; print(engine_core._core.__file__)"
    loaded = Path(run([sys.executable, "-c", code], sanitized).strip())
    assert loaded.parent == package / "engine_core"
    assert b"__asan_report" in loaded.read_bytes()
    assert b"__ubsan_handle" in loaded.read_bytes()


@pytest.mark.parametrize(
    "files",
    [
        ["tests/unit/test_session.py", "tests/unit/test_integrators.py"],
        ["tests/unit/test_bad_input.py", "tests/unit/test_settings.py"],
        ["tests/unit/test_triangulate.py", "tests/unit/test_nodes_compile.py"],
        ["tests/hostile/test_found.py"],
    ],
    ids=["renders", "bad input", "polygons and graphs", "found"],
)
def test_no_report(files: list[str], sanitized: dict[str, str]) -> None:
    # Sanitizers need more address space than that test leaves, and memory of their own.
    leave_out = "not larger_than_memory and not no_memory_behind"
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider"]
    run([*command, "-k", leave_out, *files], sanitized)
