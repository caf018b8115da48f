"""The core, built with sanitizers, renders and meets bad input without a report.

The build is kept in `build/sanitizers`, so that only the first run compiles everything. One
instruction set is enough: the sources are the same. Bounds of the standard library's containers
are checked too, and any report ends the program.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SANITIZERS = "address,undefined"
CXX_FLAGS = "-fno-sanitize-recover=all -D_GLIBCXX_ASSERTIONS"
LIBRARIES = ["libasan.so", "libubsan.so"]
#: Python keeps memory until the end. An allocation that is too large throws, as it does without.
OPTIONS = {
    "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1:quarantine_size_mb=32",
    "UBSAN_OPTIONS": "print_stacktrace=1",
}

pytestmark = pytest.mark.skipif(
    sys.version_info < (3, 13), reason="once is enough: the core does not depend on it"
)


def run(*command: str | Path, env: dict[str, str] | None = None) -> str:
    done = subprocess.run(
        [str(part) for part in command], cwd=ROOT, env=env, capture_output=True, text=True
    )
    output = done.stdout + done.stderr
    assert done.returncode == 0, output[-20_000:]
    return output


def build_environment() -> dict[str, str]:
    """This environment's own tools come first."""
    path = os.pathsep.join([sysconfig.get_path("scripts"), os.environ.get("PATH", "")])
    return {**os.environ, "PATH": path, "CXX": "g++"}


@pytest.fixture(scope="session")
def libraries() -> list[str]:
    """The sanitizers' libraries, which must be loaded before Python."""
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("g++ is not installed")
    paths = [run(compiler, f"-print-file-name={name}").strip() for name in LIBRARIES]
    if not all(os.path.isabs(path) for path in paths):
        pytest.skip("g++ is installed without its sanitizers")
    return paths


@pytest.fixture(scope="session")
def package() -> Path:
    """A folder to put on Python's path, with the core built with sanitizers."""
    folder = ROOT / "build" / "sanitizers" / SANITIZERS.replace(",", "-")
    env = build_environment()
    generator = ["-G", "Ninja"] if shutil.which("ninja", path=env["PATH"]) else []
    if (folder / "CMakeCache.txt").exists():
        generator = []  # what it was made with
    run(
        "cmake", "-S", ROOT, "-B", folder, *generator,
        f"-DPython_EXECUTABLE={sys.executable}",
        "-DVERNIER_ISAS=v2", f"-DVERNIER_SANITIZE={SANITIZERS}",
        "-DCMAKE_BUILD_TYPE=RelWithDebInfo", "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1",
        f"-DCMAKE_CXX_FLAGS={CXX_FLAGS}",
        env=env,
    )  # fmt: skip
    run("cmake", "--build", folder, "--parallel", str(os.cpu_count() or 1), env=env)
    python = folder / "package" / "engine_core"
    python.mkdir(parents=True, exist_ok=True)
    for file in (ROOT / "engine_core" / "python" / "engine_core").glob("*.py"):
        shutil.copy(file, python)
    for module in (folder / "engine_core").glob("_*.so"):
        shutil.copy(module, python)
    return python.parent


@pytest.fixture(scope="session")
def sanitized(package: Path, libraries: list[str]) -> dict[str, str]:
    """Environment variables of a process that uses the core with sanitizers."""
    return {
        **os.environ,
        **OPTIONS,
        "LD_PRELOAD": " ".join(libraries),
        "PYTHONPATH": str(package),
        "PYTHONDONTWRITEBYTECODE": "1",
    }


def test_the_sanitizers_are_at_work(sanitized: dict[str, str], package: Path) -> None:
    """Otherwise the other tests would show nothing."""
    code = "import engine_core; print(engine_core._core.__file__)"
    loaded = Path(run(sys.executable, "-c", code, env=sanitized).strip())
    assert loaded.parent == package / "engine_core"
    assert b"__asan_report" in loaded.read_bytes()
    assert b"__ubsan_handle" in loaded.read_bytes()


@pytest.mark.parametrize(
    "files",
    [
        ["tests/unit/test_session.py", "tests/unit/test_integrators.py"],
        ["tests/unit/test_bad_input.py", "tests/unit/test_settings.py"],
        ["tests/unit/test_triangulate.py", "tests/unit/test_nodes_compile.py"],
    ],
    ids=["renders", "bad input", "polygons and graphs"],
)
def test_no_report(files: list[str], sanitized: dict[str, str]) -> None:
    # Sanitizers need more address space than that test leaves, and memory of their own.
    leave_out = "not larger_than_memory and not no_memory_behind"
    run(
        sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-k", leave_out,
        *files, env=sanitized,
    )  # fmt: skip
