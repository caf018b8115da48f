"""Where a real Blender runs: a program of this machine, or the sandbox."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SANDBOX = ROOT / "scripts" / "blender_sandbox"


@dataclass(frozen=True)
class Machine:
    """Runs commands beside a Blender; `outside` and `inside` are one folder, as seen from here and
    from there."""

    blender: str
    prefix: tuple[str, ...]
    outside: Path
    inside: Path

    @staticmethod
    def find() -> Machine | str:
        """The machine that BLENDER or the sandbox gives, or why there is none."""
        program = os.environ.get("BLENDER", "")
        if program:
            if shutil.which(program) is None:
                return f"BLENDER={program} is no program"
            folder = Path(tempfile.mkdtemp(prefix="vernier-blender-"))
            return Machine(program, (), folder, folder)
        done = subprocess.run([SANDBOX, "path"], capture_output=True, text=True)
        if done.returncode != 0:
            return (
                "no Blender to test in: set BLENDER=/path/to/blender, or make the sandbox "
                "by `scripts/blender_sandbox setup`"
            )
        sandbox = Path(done.stdout.strip())
        folder = Path(tempfile.mkdtemp(prefix="vernier-blender-", dir=sandbox / "tmp"))
        folder.chmod(0o755)
        return Machine("blender", (str(SANDBOX), "run"), folder, Path("/tmp") / folder.name)

    def path(self, outside: Path) -> str:
        """A path below `outside` as commands there see it."""
        return str(self.inside / outside.relative_to(self.outside))

    def command(self, arguments: list[str], variables: dict[str, str] | None = None) -> list[str]:
        rows = [f"{name}={value}" for name, value in (variables or {}).items()]
        return [*self.prefix, "env", *rows, *arguments]

    def run(
        self,
        arguments: list[str],
        variables: dict[str, str] | None = None,
        timeout: float = 300.0,
    ) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            self.command(arguments, variables), capture_output=True, text=True, timeout=timeout
        )

    def run_blender(
        self, arguments: list[str], profile: Path, timeout: float = 300.0
    ) -> subprocess.CompletedProcess[str]:
        """Blender in the background, with its user's files in the folder `profile`."""
        variables = {"BLENDER_USER_RESOURCES": self.path(profile)}
        command = [self.blender, "--background", *arguments]
        return self.run(command, variables, timeout)
