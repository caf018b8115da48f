"""Damaged image files: cut short, without content, with headers that lie. Each is drawn as far as
it can be read, or magenta with a message; nothing is raised."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

bpy: Any = pytest.importorskip("bpy")
oiio: Any = pytest.importorskip("OpenImageIO")

from addon.sync.images import read_image  # noqa: E402
from addon.sync.report import Report  # noqa: E402

SUFFIXES = ("png", "jpg", "tif", "exr", "hdr")


def written(path: Path) -> bytes:
    """A file of noise, which does not compress to next to nothing."""
    pixels = np.random.default_rng(1).random((32, 48, 3), np.float32)
    output = oiio.ImageOutput.create(str(path))
    kind = oiio.FLOAT if path.suffix in (".exr", ".hdr") else oiio.UINT8
    assert output.open(str(path), oiio.ImageSpec(48, 32, 3, kind))
    assert output.write_image(pixels)
    output.close()
    return path.read_bytes()


def read(path: Path, sequence: bool) -> tuple[Any, list[str]]:
    """Through Blender, or as a file of a sequence, which is read by OpenImageIO."""
    image = bpy.data.images.load(str(path))
    report = Report()
    result = read_image(image, 1 if sequence else 0, report)
    bpy.data.images.remove(image)
    return result, report.messages


def check(path: Path, sequence: bool) -> None:
    result, messages = read(path, sequence)
    if result.pixels is None:
        assert any("it is drawn magenta" in message for message in messages)
    else:
        assert np.isfinite(result.pixels).all()


@pytest.mark.parametrize("sequence", [False, True], ids=["image", "sequence"])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_cut_short(empty_scene: Any, tmp_path: Path, suffix: str, sequence: bool) -> None:
    path = tmp_path / f"picture_001.{suffix}"
    data = written(path)
    assert read(path, sequence)[1] == []
    for length in (0, 1, 8, 40, len(data) // 2, len(data) - 1):
        path.write_bytes(data[:length])
        check(path, sequence)


# What reads JPEG files fills up what is missing, and says nothing.
@pytest.mark.parametrize("suffix", [suffix for suffix in SUFFIXES if suffix != "jpg"])
def test_a_file_cut_in_half_is_told_in_a_sequence(
    empty_scene: Any, tmp_path: Path, suffix: str
) -> None:
    if suffix == "tif" and bpy.app.version < (5, 0, 0):
        pytest.skip("beside this Blender, what reads TIFF files says nothing of it either")
    path = tmp_path / f"picture_001.{suffix}"
    path.write_bytes(written(path)[: path.stat().st_size // 2])
    _, messages = read(path, True)
    assert messages, "half of it is missing, and nothing is said"


def lying_png(width: int, height: int) -> bytes:
    """The header of a picture of that size, and the data of one pixel."""

    def chunk(name: bytes, content: bytes) -> bytes:
        checksum = struct.pack(">I", zlib.crc32(name + content))
        return struct.pack(">I", len(content)) + name + content + checksum

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(b"\0\1\2\3"))
        + chunk(b"IEND", b"")
    )


@pytest.mark.parametrize("sequence", [False, True], ids=["image", "sequence"])
@pytest.mark.parametrize("size", [(1000, 1000), (2**31 - 1, 2**31 - 1), (0, 0), (2**31 - 1, 1)])
def test_headers_that_lie(
    empty_scene: Any, tmp_path: Path, size: tuple[int, int], sequence: bool
) -> None:
    path = tmp_path / "picture_001.png"
    path.write_bytes(lying_png(*size))
    check(path, sequence)


@pytest.mark.parametrize("sequence", [False, True], ids=["image", "sequence"])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_changed_bytes(empty_scene: Any, tmp_path: Path, suffix: str, sequence: bool) -> None:
    """In the first bytes, where sizes and formats are."""
    path = tmp_path / f"picture_001.{suffix}"
    data = written(path)
    rng = np.random.default_rng(2)
    for _ in range(6):
        changed = bytearray(data)
        for at in rng.integers(4, min(len(data), 128), 2):
            changed[at] = rng.integers(256)
        path.write_bytes(changed)
        check(path, sequence)
