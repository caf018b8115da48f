"""Builds the extension that Blender installs: the add-on, its manifest and all wheels in one zip.

The core is compiled once; two modules are linked from it, one for the stable ABI (Python 3.12 and
later) and one for Python 3.11. Blender's own tool, as the `bpy` package carries it, makes the zip
and validates it.
"""

from __future__ import annotations

import argparse
import importlib.util
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

from vernier_tools.environment import Environment
from vernier_tools.errors import ToolError, report
from vernier_tools.wheels import glibc_needed, name_of, retag

ROOT = Path(__file__).resolve().parents[2]
COMMAND = "scripts/build_extension"

# The Pythons of the Blender versions that are supported: 4.5, 5.2, and 5.2 as Debian builds it.
PYTHONS = ("3.11", "3.13", "3.14")
# Extensions above this do not go onto Blender's platform.
MAX_BYTES = 100 * 2**20


def build(output: Path, legacy_python: Path) -> Path:
    """Builds the zip into the folder `output` and returns its path. Raises ToolError."""
    manifest = tomllib.loads((ROOT / "addon" / "blender_manifest.toml").read_text())
    version = check_version(manifest)
    output.mkdir(parents=True, exist_ok=True)
    target = output.resolve() / f"vernier-{version}.zip"
    with tempfile.TemporaryDirectory(prefix="vernier-extension-") as scratch:
        folder = Path(scratch, "vernier")
        copy_addon(folder)
        wheels = folder / "wheels"
        wheels.mkdir()
        build_core_wheels(wheels, legacy_python)
        fetch_embree_wheels(wheels)
        list_wheels(folder / "blender_manifest.toml", sorted(wheels.iterdir()))
        part = Path(scratch, target.name)
        run_blender_tool(["build", f"--source-dir={folder}", f"--output-filepath={part}"])
        run_blender_tool(["validate", str(part)])
        if part.stat().st_size > MAX_BYTES:
            raise ToolError(f"{target.name} is larger than {MAX_BYTES >> 20} MiB")
        shutil.move(part, target)
    return target


def check_version(manifest: dict[str, object]) -> str:
    """The version, which the manifest and the core's wheels must share."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    if manifest["version"] != project["version"]:
        theirs = project["version"]
        raise ToolError(
            f"the manifest's version is {manifest['version']}, pyproject.toml's {theirs}"
        )
    return str(manifest["version"])


def copy_addon(folder: Path) -> None:
    ignore = shutil.ignore_patterns("__pycache__", "*.pyc", "*.blend1")
    shutil.copytree(ROOT / "addon", folder, ignore=ignore)
    shutil.copy(ROOT / "LICENSE", folder / "LICENSE")


def build_core_wheels(wheels: Path, legacy_python: Path) -> None:
    """The core's wheels: stable ABI from this Python, then Python 3.11's from the same objects."""
    current = Environment(ROOT, Path(sys.prefix), COMMAND)
    legacy = Environment(ROOT, legacy_python.parent.parent, COMMAND)
    current.say("building the wheels of the core")
    with tempfile.TemporaryDirectory(prefix="vernier-wheels-") as scratch:
        current.build_wheel(Path(scratch), [])
        *_, compiled_in = current.core_stamp()
        legacy.build_wheel(Path(scratch), [f"cmake.define.VERNIER_CORE_FROM={compiled_in}"])
        built = sorted(Path(scratch).glob("*.whl"))
        tags = {name_of(wheel).python for wheel in built}
        if tags != {"cp311", "cp312"}:
            raise ToolError(f"wheels for cp311 and cp312 were expected, and built were {tags}")
        for wheel in built:
            major, minor = glibc_needed(wheel)
            retag(wheel, wheels, f"manylinux_{major}_{minor}_x86_64")


def fetch_embree_wheels(wheels: Path) -> None:
    """The wheels that carry Embree, one for each Python."""
    requirements = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    embree = next(item for item in requirements if item.startswith("embreex"))
    platforms = [f"--platform=manylinux_2_{minor}_x86_64" for minor in (28, 27, 17)]
    for version in PYTHONS:
        command = [sys.executable, "-m", "pip", "download", embree, "--no-deps", "--quiet"]
        command += [f"--python-version={version}", "--only-binary=:all:", *platforms]
        command += ["--platform=manylinux2014_x86_64", f"--dest={wheels}"]
        run(command, f"fetching Embree for Python {version}")


def list_wheels(manifest: Path, wheels: list[Path]) -> None:
    """Names the wheels in the manifest, before its first table."""
    rows = "".join(f'  "./wheels/{wheel.name}",\n' for wheel in wheels)
    text = manifest.read_text()
    head, mark, tail = text.partition("\n[")
    manifest.write_text(f"{head}\nwheels = [\n{rows}]\n{mark}{tail}")
    if len(tomllib.loads(manifest.read_text())["wheels"]) != len(wheels):
        raise ToolError("the wheels cannot be written into the manifest")


def run_blender_tool(arguments: list[str]) -> None:
    """Runs `blender --command extension …` without a Blender program."""
    spec = importlib.util.find_spec("bpy")
    folders = list(spec.submodule_search_locations or []) if spec is not None else []
    pattern = "*/scripts/addons_core/bl_pkg/cli/blender_ext.py"
    tools = [path for folder in folders for path in Path(folder).glob(pattern)]
    if not tools:
        raise ToolError("Blender's extension tool is not in the package bpy")
    # Tags are checked by a list that only a running Blender has.
    options = ["--valid-tags="] if arguments[0] in ("build", "validate") else []
    command = [sys.executable, str(tools[0]), arguments[0], *options, *arguments[1:]]
    run(command, f"Blender's check ({arguments[0]})")


def run(command: list[str], what: str) -> None:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise ToolError(f"{what} failed: {(done.stderr or done.stdout).strip()[-500:]}")


def main() -> int:
    parser = argparse.ArgumentParser(
        prog=COMMAND,
        description="Builds vernier-VERSION.zip, which Blender 4.5 and 5.2 install: the add-on, "
        "the compiled core (three instruction sets) and Embree for each Python.",
    )
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("dist"), help="folder of the zip (dist)"
    )
    parser.add_argument("--legacy-python", type=Path, required=True, help=argparse.SUPPRESS)
    options = parser.parse_args()
    try:
        target = build(options.output, options.legacy_python)
    except ToolError as error:
        report(COMMAND, error)
        return 1
    print(f"{target} ({target.stat().st_size / 2**20:.1f} MiB)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
