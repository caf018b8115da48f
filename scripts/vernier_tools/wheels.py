"""Wheels: what their names say, what their libraries need, and a new platform for them."""

from __future__ import annotations

import base64
import hashlib
import re
import subprocess
import tempfile
import zipfile
from pathlib import Path
from typing import NamedTuple

from vernier_tools.errors import ToolError


class WheelName(NamedTuple):
    """The parts of a wheel's file name that matter here."""

    base: str  # distribution and version
    python: str
    abi: str
    platform: str


def name_of(wheel: Path) -> WheelName:
    distribution, version, *_, python, abi, platform = wheel.stem.split("-")
    return WheelName(f"{distribution}-{version}", python, abi, platform)


def glibc_needed(wheel: Path) -> tuple[int, int]:
    """The version of the C library that the wheel's libraries need, by their symbols' versions."""
    versions = {(2, 17)}
    with tempfile.TemporaryDirectory() as scratch, zipfile.ZipFile(wheel) as archive:
        for name in archive.namelist():
            if name.endswith(".so"):
                library = archive.extract(name, scratch)
                done = subprocess.run(["objdump", "-p", library], capture_output=True, text=True)
                if done.returncode != 0:
                    raise ToolError(f"objdump cannot read {name}: {done.stderr.strip()}")
                found = re.findall(r"GLIBC_(\d+)\.(\d+)", done.stdout)
                versions |= {(int(major), int(minor)) for major, minor in found}
    return max(versions)


def retag(wheel: Path, folder: Path, platform: str) -> Path:
    """Copies the wheel into `folder` under another platform, its own record of it included."""
    name = name_of(wheel)
    tag = f"{name.python}-{name.abi}-{platform}"
    target = folder / f"{name.base}-{tag}.whl"
    info = f"{name.base}.dist-info"
    with (
        zipfile.ZipFile(wheel) as source,
        zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as result,
    ):
        about = source.read(f"{info}/WHEEL").decode()
        about = re.sub(r"(?m)^Tag: .*$", f"Tag: {tag}", about)
        record = source.read(f"{info}/RECORD").decode().splitlines()
        row = f"{info}/WHEEL,sha256={_digest(about.encode())},{len(about.encode())}"
        record = [row if line.startswith(f"{info}/WHEEL,") else line for line in record]
        texts = {f"{info}/WHEEL": about, f"{info}/RECORD": "\n".join(record) + "\n"}
        for item in source.infolist():
            content = texts.get(item.filename)
            data = source.read(item) if content is None else content.encode()
            result.writestr(item, data, zipfile.ZIP_DEFLATED)
    return target


def _digest(data: bytes) -> str:
    """As RECORD has it: URL-safe base64 without padding."""
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
