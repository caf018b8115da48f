"""The zip in a Blender that has never run: installing, upgrading, removing."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from .conftest import install
from .machine import Machine

ENGINE = """
import bpy
bpy.context.scene.render.engine = "VERNIER"
import engine_core
print("CORE", engine_core.INSTRUCTION_SET, engine_core.__file__)
"""


def engine(machine: Machine, profile: Path) -> tuple[int, str]:
    """What a new Blender says when asked to use the engine."""
    script = profile / "engine.py"
    script.write_text(ENGINE)
    done = machine.run_blender(
        ["--python-exit-code", "9", "--python", machine.path(script)], profile
    )
    return done.returncode, done.stdout + done.stderr


def remove(machine: Machine, profile: Path) -> str:
    done = machine.run_blender(["--command", "extension", "remove", "vernier"], profile)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def leftovers(profile: Path) -> list[Path]:
    """Files of the extension and of its wheels."""
    names = ("vernier", "engine_core", "embreex")
    return [p for p in profile.rglob("*") if p.name.split(".")[0].split("-")[0] in names]


def test_blender_finds_the_zip_valid(
    machine: Machine, extension: Path, empty_profile: Path
) -> None:
    done = machine.run_blender(
        ["--command", "extension", "validate", machine.path(extension)], empty_profile
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert extension.stat().st_size < 100e6


def test_it_installs_works_and_leaves_nothing(
    machine: Machine, extension: Path, empty_profile: Path
) -> None:
    text = install(machine, extension, empty_profile)
    assert "Traceback" not in text
    code, text = engine(machine, empty_profile)
    assert code == 0, text
    assert "CORE v" in text
    assert leftovers(empty_profile)
    assert "Traceback" not in remove(machine, empty_profile)
    code, text = engine(machine, empty_profile)
    assert code == 9
    assert "VERNIER" in text
    assert leftovers(empty_profile) == []


def test_it_replaces_an_older_one(machine: Machine, extension: Path, empty_profile: Path) -> None:
    older = empty_profile / "vernier-0.0.1.zip"
    repack(extension, older, "0.0.1")
    install(machine, older, empty_profile)
    install(machine, extension, empty_profile)
    manifests = [p.read_text() for p in empty_profile.rglob("vernier/blender_manifest.toml")]
    assert len(manifests) == 1
    assert 'version = "0.0.1"' not in manifests[0]
    libraries = list(empty_profile.rglob("site-packages/vernier-*.dist-info"))
    assert len(libraries) == 1
    assert "0.0.1" not in libraries[0].name
    code, text = engine(machine, empty_profile)
    assert code == 0, text


@pytest.mark.parametrize(
    ("declared", "demanded", "said"),
    [
        ('blender_version_min = "4.5.0"', 'blender_version_min = "99.0.0"', "99.0.0"),
        ('platforms = ["linux-x64"]', 'platforms = ["windows-x64"]', "windows-x64"),
    ],
    ids=["version", "platform"],
)
def test_it_is_refused_where_it_does_not_run(
    machine: Machine, extension: Path, empty_profile: Path, declared: str, demanded: str, said: str
) -> None:
    other = empty_profile / "vernier-other.zip"
    with zipfile.ZipFile(extension) as source, zipfile.ZipFile(other, "w") as target:
        for item in source.infolist():
            data = source.read(item)
            if item.filename.endswith("blender_manifest.toml"):
                assert declared.encode() in data
                data = data.replace(declared.encode(), demanded.encode())
            target.writestr(item.filename, data)
    command = ["--command", "extension", "install-file", "-r", "user_default", "-e"]
    done = machine.run_blender([*command, machine.path(other)], empty_profile)
    text = done.stdout + done.stderr
    assert said in text
    assert "Traceback" not in text
    assert leftovers(empty_profile) == [other]


def repack(source: Path, target: Path, version: str) -> None:
    """Copies an extension under another version, that of its own wheels included."""
    with zipfile.ZipFile(source) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    manifest_name = next(name for name in members if name.endswith("blender_manifest.toml"))
    manifest = members[manifest_name].decode()
    current = manifest.split('\nversion = "')[1].split('"')[0]
    with zipfile.ZipFile(target, "w") as archive:
        for name, data in members.items():
            if name == manifest_name:
                text = manifest.replace(f'\nversion = "{current}"', f'\nversion = "{version}"')
                data = text.replace(f"vernier-{current}-", f"vernier-{version}-").encode()
            if f"vernier-{current}-" in name:
                data = renamed_wheel(data, current, version)
                name = name.replace(f"vernier-{current}-", f"vernier-{version}-")
            archive.writestr(name, data)


def renamed_wheel(data: bytes, current: str, version: str) -> bytes:
    import io

    result = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as source, zipfile.ZipFile(result, "w") as target:
        for item in source.infolist():
            name = item.filename.replace(f"vernier-{current}.", f"vernier-{version}.")
            content = source.read(item)
            if name.endswith("RECORD"):
                old, new = f"vernier-{current}.".encode(), f"vernier-{version}.".encode()
                content = content.replace(old, new)
            target.writestr(name, content)
    return result.getvalue()


def test_a_file_opens_without_the_extension(
    machine: Machine, profile: Path, empty_profile: Path
) -> None:
    path = machine.path(empty_profile / "kept.blend")
    script = empty_profile / "save.py"
    script.write_text(
        f"""
import bpy
bpy.context.scene.render.engine = "VERNIER"
bpy.context.scene.vernier.samples = 77
bpy.ops.wm.save_as_mainfile(filepath={path!r})
"""
    )
    done = machine.run_blender(
        ["--python-exit-code", "9", "--python", machine.path(script)], profile
    )
    assert done.returncode == 0, done.stdout + done.stderr
    look = empty_profile / "look.py"
    look.write_text(
        """
import bpy
assert len(bpy.data.objects) == 3
assert not hasattr(bpy.context.scene, "vernier")
bpy.ops.wm.save_mainfile()
"""
    )
    arguments = ["--python-exit-code", "9", path, "--python", machine.path(look)]
    done = machine.run_blender(arguments, empty_profile)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    # The settings are still there for a Blender that has it.
    look.write_text("import bpy\nassert bpy.context.scene.vernier.samples == 77\n")
    done = machine.run_blender(arguments, profile)
    assert done.returncode == 0, done.stdout + done.stderr
