"""Wheels of the extension: their names, what they need, their own record of their files."""

from __future__ import annotations

import base64
import csv
import hashlib
import io
import zipfile
from pathlib import Path

import pytest
from vernier_tools import wheels
from vernier_tools.build_extension import list_wheels

ABOUT = "Wheel-Version: 1.0\nRoot-Is-Purelib: false\nTag: cp312-abi3-linux_x86_64\n"


def digest(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


@pytest.fixture
def wheel(tmp_path: Path) -> Path:
    """A wheel of one module."""
    path = tmp_path / "thing-1.2-cp312-abi3-linux_x86_64.whl"
    info = "thing-1.2.dist-info"
    members = {"thing.py": b"x = 1\n", f"{info}/WHEEL": ABOUT.encode()}
    record = "".join(f"{n},sha256={digest(d)},{len(d)}\n" for n, d in members.items())
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
        archive.writestr(f"{info}/RECORD", record + f"{info}/RECORD,,\n")
    return path


def test_names(wheel: Path) -> None:
    assert wheels.name_of(wheel) == ("thing-1.2", "cp312", "abi3", "linux_x86_64")


def test_another_platform(wheel: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    result = wheels.retag(wheel, tmp_path / "out", "manylinux_2_35_x86_64")
    assert result.name == "thing-1.2-cp312-abi3-manylinux_2_35_x86_64.whl"
    with zipfile.ZipFile(result) as archive:
        about = archive.read("thing-1.2.dist-info/WHEEL").decode()
        assert "Tag: cp312-abi3-manylinux_2_35_x86_64\n" in about
        text = archive.read("thing-1.2.dist-info/RECORD").decode()
        for name, checksum, size in csv.reader(io.StringIO(text)):
            if checksum:
                data = archive.read(name)
                assert checksum == f"sha256={digest(data)}"
                assert int(size) == len(data)


def test_the_manifest_lists_the_wheels(wheel: Path, tmp_path: Path) -> None:
    import tomllib

    manifest = tmp_path / "blender_manifest.toml"
    manifest.write_text('id = "thing"\n\n[build]\npaths = []\n')
    list_wheels(manifest, [wheel])
    parsed = tomllib.loads(manifest.read_text())
    assert parsed["wheels"] == [f"./wheels/{wheel.name}"]
    assert parsed["build"] == {"paths": []}
