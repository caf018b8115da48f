"""Makes the project's Python environment ready: packages installed, core built and up to date.

Run by `environment.sh` with a bare interpreter, so only the standard library is used here. What is
to be installed is declared in `pyproject.toml` alone. A call that finds everything ready costs a
few hundredths of a second: two stamps in the environment's folder say which requirements are
installed and from which sources the core was built.
"""

from __future__ import annotations

import argparse
import fcntl
import hashlib
import os
import re
import shutil
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from vernier_tools.errors import ToolError, report

COMPILERS = ("g++", "clang++", *(f"g++-{n}" for n in range(16, 11, -1)))
COMPILERS += tuple(f"clang++-{n}" for n in range(22, 14, -1))

# Lines in which pip says no more than that something failed.
PIP_SAYS_NOTHING = ("error: subprocess-exited-with-error", "error: metadata-generation-failed")

# Tells a compiler that knows the C++20 library from one that does not.
CXX_PROBE = """
#include <bit>
#include <concepts>
#include <numbers>
#include <optional>
#include <span>
template <std::floating_point T> constexpr T twice(T x) { return 2 * x; }
static_assert(twice(1.0f) == 2.0f && std::has_single_bit(4u));
"""


class Environment:
    """One virtual environment at `folder` for the project at `root`; `say` shows progress."""

    def __init__(self, root: Path, folder: Path, command: str) -> None:
        self.root = root
        self.folder = folder
        self.command = command
        self.python = folder / "bin" / "python"
        self.log = folder / "setup.log"
        self.project = tomllib.loads((root / "pyproject.toml").read_text())

    def say(self, text: str) -> None:
        print(f"{self.command}: {text}", file=sys.stderr, flush=True)

    def ensure(self, extras: list[str], with_core: bool = True) -> None:
        """Brings the environment up to date with the given extras of the project.

        Raises ToolError when a step fails. Calls at the same time wait for one another.
        """
        with self.locked():
            if not self.runs():
                self.create()
            self.install_requirements(extras)
            if with_core:
                self.build_core()

    @property
    def build_folder(self) -> Path:
        """Where the core is compiled for this environment."""
        return self.root / "build" / self.folder.name.lstrip(".")

    @contextmanager
    def locked(self, wait: bool = True) -> Iterator[None]:
        """Keeps other calls out; raises BlockingIOError when one is in and this is not to wait."""
        lock = self.folder.with_name(self.folder.name + ".lock")
        with open(lock, "w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                if not wait:
                    raise
                self.say("waiting for another call that prepares the environment")
                fcntl.flock(file, fcntl.LOCK_EX)
            yield

    def runs(self) -> bool:
        probe = [str(self.python), "-c", "import pip"]
        try:
            return subprocess.run(probe, capture_output=True).returncode == 0
        except OSError:
            return False

    def create(self) -> None:
        self.say(f"making {self.folder.name} (once)")
        shutil.rmtree(self.folder, ignore_errors=True)
        # The interpreter that runs this may itself be a virtual environment's.
        base = getattr(sys, "_base_executable", sys.executable)
        done = subprocess.run([base, "-m", "venv", self.folder], capture_output=True, text=True)
        if done.returncode != 0:
            raise ToolError(f"{base} cannot make a virtual environment: {done.stdout}{done.stderr}")

    def install_requirements(self, extras: list[str]) -> None:
        declared = self.project["project"].get("optional-dependencies", {})
        wanted = list(self.project["build-system"]["requires"])
        wanted += self.project["project"].get("dependencies", [])
        for extra in extras:
            if extra not in declared:
                raise ToolError(f"pyproject.toml declares no extra named {extra}")
            wanted += declared[extra]
        stamp = self.folder / "requirements.stamp"
        installed = stamp.read_text().splitlines() if stamp.exists() else []
        missing = sorted(set(wanted) - set(installed))
        if not missing:
            return
        self.say("installing " + ", ".join(requirement_names(missing)) + " (once)")
        self.pip(["install", *missing], "installing packages")
        self.install_build_tools()
        stamp.write_text("\n".join(sorted({*installed, *wanted})) + "\n")

    def install_build_tools(self) -> None:
        """What the build backend asks for beyond its requirements: CMake, where it is missing."""
        backend = self.project["build-system"]["build-backend"]
        ask = f"import {backend} as b; print(*b.get_requires_for_build_wheel(), sep='\\n')"
        folders = self.project["build-system"].get("backend-path", [])
        done = subprocess.run(
            [str(self.python), "-c", ask],
            cwd=self.root,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(folders)},
            capture_output=True,
            text=True,
        )
        if done.returncode != 0:
            raise ToolError(f"the build backend {backend} does not work: {done.stderr[-300:]}")
        if tools := [line for line in done.stdout.splitlines() if line]:
            self.pip(["install", *tools], "installing build tools")

    def build_core(self) -> None:
        state = source_hash(self.root)
        if self.core_stamp()[:1] == [state]:
            return
        self.stamp.unlink(missing_ok=True)
        compiler = find_compiler(self.folder)
        self.say(f"building the core with {compiler}")
        start = time.monotonic()
        with ExitStack() as held:
            shared = self.shared_core([state, compiler], held)
            option = f"--config-settings=cmake.define.VERNIER_CORE_FROM={shared or ''}"
            self.run_backend(["install", "--force-reinstall", option], compiler)
        self.stamp.write_text(f"{state}\n{compiler}\n{shared or self.build_folder}\n")
        self.say(f"built in {time.monotonic() - start:.0f} s")

    @property
    def stamp(self) -> Path:
        return self.folder / "core.stamp"

    def core_stamp(self) -> list[str]:
        """Of the core that is installed: the digest of its sources, the compiler, and the build
        folder whose libraries it was linked from. Empty when there is none."""
        return self.stamp.read_text().splitlines() if self.stamp.exists() else []

    def shared_core(self, wanted: list[str], held: ExitStack) -> Path | None:
        """The build folder of the project's environment for another Python, where that has compiled
        the wanted sources by the wanted compiler, and nobody is at work there, nor will be while
        `held` is open: the core knows nothing of Python, so its libraries need only be linked.
        """
        for stamp in sorted(self.root.glob(".venv*/core.stamp")):
            other = Environment(self.root, stamp.parent, self.command)
            try:
                held.enter_context(other.locked(wait=False))  # which is also busy when it is this
            except BlockingIOError:
                continue
            if other.core_stamp() == [*wanted, str(other.build_folder)]:
                return other.build_folder
        return None

    def build_wheel(self, into: Path, options: list[str]) -> None:
        """Builds the core's wheel for this environment's Python into the folder `into`.

        `options` are settings of the build backend, as KEY=VALUE. Raises ToolError.
        """
        with self.locked():
            settings = [f"--config-settings={option}" for option in options]
            compiler = find_compiler(self.folder)
            self.run_backend(["wheel", f"--wheel-dir={into}", *settings], compiler)

    def run_backend(self, command: list[str], compiler: str) -> None:
        """Lets pip install the project or build its wheel, compiled in `build_folder`."""
        arguments = [*command, "--no-deps", "--no-build-isolation"]
        arguments += [f"--config-settings=build-dir={self.build_folder}", str(self.root)]
        variables = {"CXX": compiler, "CC": c_compiler(compiler)}
        # Without this, a build by make would use one processor alone.
        variables["CMAKE_BUILD_PARALLEL_LEVEL"] = os.environ.get(
            "CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count() or 1)
        )
        self.pip(arguments, "building the core", variables)

    def pip(self, arguments: list[str], what: str, variables: dict[str, str] | None = None) -> None:
        """Runs the environment's pip, its output in the log; raises ToolError when it fails."""
        path = os.pathsep.join([str(self.folder / "bin"), os.environ.get("PATH", "")])
        command = [str(self.python), "-m", "pip", *arguments]
        with open(self.log, "a") as log:
            print(f"\n$ {' '.join(command)}", file=log, flush=True)
            start = log.tell()
            done = subprocess.run(
                command,
                stdout=log,
                stderr=subprocess.STDOUT,
                env={**os.environ, "PATH": path, **(variables or {})},
            )
        if done.returncode != 0:
            with open(self.log) as log:
                log.seek(start)
                text = log.read()
            raise ToolError(f"{what} failed: {first_error(text)} (all of it: {self.log})")


def requirement_names(requirements: list[str]) -> list[str]:
    """The names alone, each once, without versions and environment markers."""
    names = [
        re.split(r"[^A-Za-z0-9._-]", requirement, maxsplit=1)[0] for requirement in requirements
    ]
    return list(dict.fromkeys(names))


def first_error(text: str) -> str:
    """The line of a failed build or installation that most likely names the cause."""
    lines = [line.strip(" |+-") for line in text.splitlines() if line.strip(" |+-")]
    lines = [line for line in lines if not line.startswith(PIP_SAYS_NOTHING)]
    for mark in (": error:", "fatal error", "CMake Error", "Error: ", "ERROR:", "error:"):
        for line in lines:
            if mark in line:
                return line
    return lines[-1] if lines else "no output"


def source_hash(root: Path) -> str:
    """A digest of all that the built core depends on."""
    digest = hashlib.sha256()
    files = [root / "pyproject.toml", root / "CMakeLists.txt"]
    for folder, folders, names in os.walk(root / "engine_core"):
        folders[:] = sorted(name for name in folders if name != "__pycache__")
        files += [Path(folder, name) for name in sorted(names)]
    for path in files:
        if path.exists():
            content = path.read_bytes()
            digest.update(f"{path.relative_to(root)}\0{len(content)}\0".encode())
            digest.update(content)
    return digest.hexdigest()


def find_compiler(scratch: Path) -> str:
    """The first C++ compiler that compiles C++20: $CXX, else the usual names. Raises ToolError."""
    chosen = os.environ.get("CXX")
    rejected = []
    for name in [chosen] if chosen else COMPILERS:
        path = shutil.which(name)
        if path is None:
            continue
        probe = [path, "-std=c++20", "-fsyntax-only", "-x", "c++", "-"]
        done = subprocess.run(probe, input=CXX_PROBE, capture_output=True, text=True, cwd=scratch)
        if done.returncode == 0:
            return path
        rejected.append(path)
    if chosen:
        raise ToolError(f"CXX={chosen} does not compile C++20 (g++ 12 or clang 15 is needed)")
    if rejected:
        found = ", ".join(rejected)
        raise ToolError(f"g++ 12 or clang 15 or later is needed; too old: {found}")
    raise ToolError("no C++ compiler was found: install g++ (12 or later) or clang (15 or later)")


def c_compiler(cxx: str) -> str:
    """The C compiler that goes with a C++ compiler; CMake's probes may ask for one."""
    folder, name = os.path.split(cxx)
    companion = name.replace("clang++", "clang").replace("g++", "gcc")
    path = os.path.join(folder, companion)
    return os.environ.get("CC", path if os.path.exists(path) else cxx)


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--name", required=True)
    parser.add_argument("--root", type=Path, required=True)
    parser.add_argument("--environment", type=Path, required=True)
    parser.add_argument("--no-core", action="store_true")
    parser.add_argument("extras", nargs="*")
    options = parser.parse_args()
    try:
        environment = Environment(options.root, options.environment, options.name)
        environment.ensure(options.extras, with_core=not options.no_core)
    except ToolError as error:
        report(options.name, error)
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
