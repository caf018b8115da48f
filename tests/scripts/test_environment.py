"""The bootstrap: finds a Python that runs, installs, builds once, and says what is wrong."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from vernier_tools import environment
from vernier_tools.errors import ToolError

ROOT = Path(__file__).parents[2]

PYPROJECT = """
[build-system]
requires = []
build-backend = "backend"
backend-path = ["."]
[project]
name = "stand-in"
version = "1"
[project.optional-dependencies]
blender = []
test = []
"""

# A build backend without dependencies, in place of the real core's. It counts its runs.
BACKEND = """
import pathlib, sys, zipfile

def get_requires_for_build_wheel(config_settings=None):
    return []

def build_wheel(folder, config_settings=None, metadata_directory=None):
    source = pathlib.Path("engine_core/source.py").read_text()
    if "broken" in source:
        sys.exit("source.cpp:7:3: error: expected ';' before '}' token")
    with open("builds", "a") as file:
        file.write("x")
    pathlib.Path("linked").write_text(config_settings["cmake.define.VERNIER_CORE_FROM"])
    name = "stand_in-1-py3-none-any.whl"
    info = "stand_in-1.dist-info/"
    with zipfile.ZipFile(pathlib.Path(folder, name), "w") as wheel:
        wheel.writestr("stand_in.py", source)
        wheel.writestr(info + "METADATA", "Metadata-Version: 2.1\\nName: stand-in\\nVersion: 1\\n")
        wheel.writestr(info + "WHEEL", "Wheel-Version: 1.0\\nGenerator: x\\n"
                       "Root-Is-Purelib: true\\nTag: py3-none-any\\n")
        wheel.writestr(info + "RECORD", "")
    return name
"""

PREPARE = """
. scripts/environment.sh
prepare_environment blender
"$python" -c 'import stand_in; print(stand_in.value)'
"""


def make_project(folder: Path) -> Path:
    """A small project with the real scripts."""
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "scripts", folder / "scripts", ignore=ignored)
    (folder / "pyproject.toml").write_text(PYPROJECT)
    (folder / "backend.py").write_text(BACKEND)
    (folder / "builds").touch()
    (folder / "engine_core").mkdir()
    write_source(folder, "value = 1")
    return folder


def write_source(project: Path, text: str) -> None:
    (project / "engine_core" / "source.py").write_text(text)


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One for all tests that do not mind what state it is in: an environment takes seconds."""
    return make_project(tmp_path_factory.mktemp("project"))


def variables(**more: str) -> dict[str, str]:
    clean = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV", "CXX")}
    return {**clean, "VERNIER_PYTHON": sys.executable, **more}


def prepare(project: Path, **more: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["bash", "-c", PREPARE], cwd=project, env=variables(**more), capture_output=True, text=True
    )


def builds(project: Path) -> int:
    return len((project / "builds").read_text())


def test_builds_once_and_again_only_when_a_source_changed(project: Path) -> None:
    write_source(project, "value = 10")
    first = prepare(project)
    assert (first.returncode, first.stdout) == (0, "10\n"), first.stderr
    assert "building the core" in first.stderr
    done = builds(project)

    second = prepare(project)
    assert (second.returncode, second.stdout, second.stderr) == (0, "10\n", "")
    assert builds(project) == done

    write_source(project, "value = 11")
    third = prepare(project)
    assert (third.returncode, third.stdout) == (0, "11\n"), third.stderr
    assert builds(project) == done + 1


@pytest.mark.parametrize("command", ["render", "compare_cycles", "benchmark"])
def test_help_is_answered_before_there_is_an_environment(tmp_path: Path, command: str) -> None:
    make_project(tmp_path)
    done = subprocess.run(
        [tmp_path / "scripts" / command, "some.blend", "--help"],
        cwd=tmp_path,
        env=variables(),
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(f"usage: scripts/{command} ")
    assert not list(tmp_path.glob(".venv*"))
    assert builds(tmp_path) == 0


def test_calls_at_the_same_time_build_once(tmp_path: Path) -> None:
    make_project(tmp_path)
    running = [
        subprocess.Popen(
            ["bash", "-c", PREPARE],
            cwd=tmp_path,
            env=variables(),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        for _ in range(3)
    ]
    outputs = [process.communicate() for process in running]
    assert [process.returncode for process in running] == [0, 0, 0], outputs
    assert [out for out, _ in outputs] == [b"1\n"] * 3
    assert builds(tmp_path) == 1


def test_a_core_compiled_for_another_python_is_linked(project: Path) -> None:
    """Its sources and compiler being the same, and nobody at work there."""
    write_source(project, "value = 20")
    assert prepare(project).returncode == 0
    mine = environment.Environment(project, next(project.glob(".venv*/")), "x")
    state, compiler, folder = mine.core_stamp()
    assert folder == str(mine.build_folder)
    assert (project / "linked").read_text() == ""

    other = environment.Environment(project, project / ".venv-other", "x")
    other.folder.mkdir()
    for compiled, linked in (
        ([state, compiler, other.build_folder], str(other.build_folder)),
        (["older", compiler, other.build_folder], ""),
        ([state, "another", other.build_folder], ""),
        ([state, compiler, mine.build_folder], ""),
    ):
        other.stamp.write_text("".join(f"{text}\n" for text in compiled))
        mine.stamp.unlink()
        assert prepare(project).returncode == 0
        assert (project / "linked").read_text() == linked
        assert mine.core_stamp() == [state, compiler, linked or str(mine.build_folder)]

    other.stamp.write_text(f"{state}\n{compiler}\n{other.build_folder}\n")
    mine.stamp.unlink()
    with other.locked():
        assert prepare(project).returncode == 0
    assert (project / "linked").read_text() == ""
    shutil.rmtree(other.folder)


def test_a_failed_build_names_the_error_and_is_tried_again(project: Path) -> None:
    write_source(project, "broken")
    for _ in range(2):
        failed = prepare(project)
        assert failed.returncode == 2
        last = failed.stderr.splitlines()[-1]
        assert "error: building the core failed" in last
        assert "expected ';'" in last
        assert "setup.log" in last
    write_source(project, "value = 20")
    assert prepare(project).stdout == "20\n"


def test_an_environment_whose_python_is_gone_is_made_anew(project: Path) -> None:
    assert prepare(project).returncode == 0
    (folder,) = project.glob(".venv*/")
    (folder / "bin" / "python").unlink()
    again = prepare(project)
    assert again.returncode == 0, again.stderr
    assert "making .venv" in again.stderr


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ("/nowhere/python3", "/nowhere/python3 does not run"),
        ("/bin/true", "/bin/true does not run"),
    ],
)
def test_a_bad_choice_of_python_is_told(project: Path, choice: str, message: str) -> None:
    done = prepare(project, VERNIER_PYTHON=choice)
    assert done.returncode == 2
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_python_of_another_version_is_told(project: Path) -> None:
    other = project / "python3.10"
    other.write_text("#!/bin/sh\necho 3.10\n")
    other.chmod(0o755)
    done = prepare(project, VERNIER_PYTHON=str(other))
    assert done.returncode == 2
    assert "is Python 3.10; 3.13 or 3.11 is needed" in done.stderr


def test_python_on_the_path_that_does_not_run_is_passed_over(project: Path) -> None:
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    for folder, text in (
        ("shims", "echo 'pyenv: command not found' >&2; exit 127"),
        ("good", f'exec "{sys.executable}" "$@"'),
    ):
        program = project / folder / f"python{version}"
        program.parent.mkdir()
        program.write_text(f"#!/bin/sh\n{text}\n")
        program.chmod(0o755)
    path = os.pathsep.join([str(project / "shims"), str(project / "good"), os.environ["PATH"]])
    script = f'. scripts/environment.sh; find_python {version} && echo "$base_python"'
    done = subprocess.run(
        ["bash", "-c", script],
        cwd=project,
        env=variables(PATH=path),
        capture_output=True,
        text=True,
    )
    assert done.stdout == f"{project}/good/python{version}\n"


def test_no_python_is_told(tmp_path: Path) -> None:
    if Path("/usr/local/bin/python3.13").exists() or list(Path("/opt").glob("python/3.13*")):
        pytest.skip("this system has a Python 3.13 where it is found without PATH")
    project = make_project(tmp_path)
    tools = project / "tools"
    tools.mkdir()
    for name in ("bash", "uname", "dirname", "basename"):
        (tools / name).symlink_to(str(shutil.which(name)))
    done = prepare(
        project, VERNIER_PYTHON="3.13", PATH=str(tools), HOME=str(project), PYENV_ROOT=str(project)
    )
    assert done.returncode == 2
    assert "no working CPython 3.13 was found" in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_missing_or_old_compiler_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CXX", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ToolError, match=r"no C\+\+ compiler was found: install g\+\+"):
        environment.find_compiler(tmp_path)
    old = tmp_path / "g++"
    old.write_text("#!/bin/sh\nexit 1\n")
    old.chmod(0o755)
    with pytest.raises(ToolError, match=r"too old: .*/g\+\+"):
        environment.find_compiler(tmp_path)
    monkeypatch.setenv("CXX", str(old))
    with pytest.raises(ToolError, match="does not compile"):
        environment.find_compiler(tmp_path)


def test_requirements_are_named_without_versions_and_markers() -> None:
    wanted = ["bpy==5.2.*; python_version >= '3.13'", "bpy==4.5.*; x", "flip-evaluator>=1.7", "a.b"]
    assert environment.requirement_names(wanted) == ["bpy", "flip-evaluator", "a.b"]
