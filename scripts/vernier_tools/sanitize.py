"""Runs the core built with the compiler's sanitizers, for longer than the test suite does: on saved
scenes that are changed under guidance of what they make run, on generated descriptions, and on
several threads."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from vernier_tools import command_lines, sanitized_build
from vernier_tools.errors import ToolError, report
from vernier_tools.sanitized_build import FUZZ, MEMORY, THREADS, Kind

ROOT = Path(__file__).resolve().parents[2]
COMMAND = "scripts/sanitize"
TESTS = ROOT / "tests"
#: Of the two tests of generated descriptions, in one round, as many times as the bounded run has.
EFFORT = 4


def call(command: list[str | Path], env: dict[str, str]) -> bool:
    """Runs it with its output shown. Whether it found nothing."""
    return subprocess.run([str(part) for part in command], cwd=ROOT, env=env).returncode == 0


def run_files(minutes: float, seed: int, env: dict[str, str], output: Path) -> bool:
    fuzzer = TESTS / "hostile" / "fuzz_files.py"
    fine = call(
        [sys.executable, fuzzer, output, "--minutes", str(minutes), "--seed", str(seed)], env
    )
    if not fine:
        print(f"the file at fault: {output / 'at_fault.vernier'}")
    return fine


def run_descriptions(minutes: float, seed: int, env: dict[str, str], output: Path) -> bool:
    del output
    end = time.monotonic() + 60.0 * minutes
    env = {**env, "VERNIER_HOSTILE_EFFORT": str(EFFORT)}
    rounds = 0
    while time.monotonic() < end:
        command: list[str | Path] = [sys.executable, "-m", "pytest", "-q", "-x"]
        # Uncaptured, or what the sanitizer says would be lost with the process that it ends.
        command += ["--capture=no", "-p", "no:cacheprovider", "-k", "scenes_are"]
        command += [
            TESTS / "hostile" / "test_descriptions.py",
            f"--hypothesis-seed={seed + rounds}",
        ]
        if not call(command, env):
            return False
        rounds += 1
    print(f"{rounds} rounds of {2 * 60 * EFFORT} descriptions")
    return True


def run_threads(minutes: float, seed: int, env: dict[str, str], output: Path) -> bool:
    del minutes, seed, output
    return call([sys.executable, TESTS / "sanitizers" / "render_everything.py"], env)


PARTS: dict[str, tuple[Kind, Callable[[float, int, dict[str, str], Path], bool]]] = {
    "files": (FUZZ, run_files),
    "descriptions": (MEMORY, run_descriptions),
    "threads": (THREADS, run_threads),
}


def main() -> int:
    options = command_lines.sanitize(sys.argv[1:])
    kind, run = PARTS[options.part]
    try:
        package = sanitized_build.build(kind, options.build)
        env = sanitized_build.environment(kind, package)
    except ToolError as error:
        report(COMMAND, error)
        return 2
    env["PYTHONPATH"] = os.pathsep.join([env["PYTHONPATH"], str(ROOT), str(TESTS / "support")])
    return 0 if run(options.minutes, options.seed, env, options.output) else 1


if __name__ == "__main__":
    sys.exit(main())
