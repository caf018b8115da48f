"""Builds of the core with the compiler's sanitizers, and the environment that they run in.

A build is kept in `build/sanitizers`, so that only the first one compiles everything. One
instruction set is enough: the sources are the same. Bounds of the standard library's containers are
checked too, and any report ends the program.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vernier_tools.errors import ToolError

ROOT = Path(__file__).resolve().parents[2]
CXX_FLAGS = "-fno-sanitize-recover=all -D_GLIBCXX_ASSERTIONS"
#: What is known to be no race, with reasons.
SUPPRESSIONS = ROOT / "tests" / "sanitizers" / "threads.supp"


@dataclass(frozen=True)
class Kind:
    """What a build is for."""

    name: str
    #: As for -fsanitize=.
    sanitizers: str
    #: Must be loaded before Python.
    libraries: tuple[str, ...]
    options: tuple[tuple[str, str], ...]
    fuzz: bool = False


#: Python keeps memory until the end. An allocation that is too large throws, as it does without.
_MEMORY_OPTIONS = (
    ("ASAN_OPTIONS", "detect_leaks=0:allocator_may_return_null=1:quarantine_size_mb=32"),
    ("UBSAN_OPTIONS", "print_stacktrace=1"),
)
_MEMORY_LIBRARIES = ("libasan.so", "libubsan.so")
MEMORY = Kind("address-undefined", "address,undefined", _MEMORY_LIBRARIES, _MEMORY_OPTIONS)
FUZZ = Kind("fuzz", "address,undefined", _MEMORY_LIBRARIES, _MEMORY_OPTIONS, fuzz=True)
THREADS = Kind(
    "thread",
    "thread",
    ("libtsan.so",),
    # Embree, TBB, numpy and Python are not compiled with it: what they do among themselves is not
    # looked at.
    (("TSAN_OPTIONS", f"suppressions={SUPPRESSIONS}:ignore_noninstrumented_modules=1:"
                      "second_deadlock_stack=1:exitcode=66"),),
)  # fmt: skip


def run(command: Sequence[str | Path], env: dict[str, str] | None = None) -> str:
    """Its output. Raises ToolError with the last of it where the command fails."""
    done = subprocess.run(
        [str(part) for part in command], cwd=ROOT, env=env, capture_output=True, text=True
    )
    output = done.stdout + done.stderr
    if done.returncode != 0:
        raise ToolError(output[-20_000:])
    return output


def libraries(kind: Kind) -> list[str]:
    """Where the sanitizers' libraries are. Raises ToolError where there are none."""
    compiler = shutil.which("g++")
    if compiler is None:
        raise ToolError("g++ is not installed")
    paths = [run([compiler, f"-print-file-name={name}"]).strip() for name in kind.libraries]
    if not all(os.path.isabs(path) for path in paths):
        raise ToolError("g++ is installed without its sanitizers")
    return paths


def build(kind: Kind, folder: Path | None = None) -> Path:
    """Builds what has changed. Returns a folder for Python's path. Raises ToolError."""
    folder = folder or ROOT / "build" / "sanitizers" / kind.name
    # This environment's own tools come first.
    path = os.pathsep.join([sysconfig.get_path("scripts"), os.environ.get("PATH", "")])
    env = {**os.environ, "PATH": path, "CXX": "g++"}
    generator = ["-G", "Ninja"] if shutil.which("ninja", path=env["PATH"]) else []
    if (folder / "CMakeCache.txt").exists():
        generator = []  # what it was made with
    run(
        [
            "cmake", "-S", ROOT, "-B", folder, *generator,
            f"-DPython_EXECUTABLE={sys.executable}",
            "-DVERNIER_ISAS=v2", f"-DVERNIER_SANITIZE={kind.sanitizers}",
            f"-DVERNIER_FUZZ={'ON' if kind.fuzz else 'OFF'}",
            "-DCMAKE_BUILD_TYPE=RelWithDebInfo", "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1",
            f"-DCMAKE_CXX_FLAGS={CXX_FLAGS}",
        ],
        env=env,
    )  # fmt: skip
    run(["cmake", "--build", folder, "--parallel", str(os.cpu_count() or 1)], env=env)
    python = folder / "package" / "engine_core"
    python.mkdir(parents=True, exist_ok=True)
    for file in (ROOT / "engine_core" / "python" / "engine_core").glob("*.py"):
        shutil.copy(file, python)
    for module in (folder / "engine_core").glob("_*.so"):
        shutil.copy(module, python)
    return python.parent


def environment(kind: Kind, package: Path) -> dict[str, str]:
    """Environment variables of a process that uses that build. Raises ToolError."""
    return {
        **os.environ,
        **dict(kind.options),
        "LD_PRELOAD": " ".join(libraries(kind)),
        "PYTHONPATH": str(package),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
