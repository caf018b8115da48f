"""Descriptions in files: what comes back is what went in, and damage is told in one sentence."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from engine_core.description import SceneDescription
from engine_core.storage import FORMAT, StorageError, load, save
from engine_core.validation import DescriptionError
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.unit.test_validation import example


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and bool((a == b).all())
    if dataclasses.is_dataclass(a):
        names = [field.name for field in dataclasses.fields(a)]
        return type(a) is type(b) and all(_same(getattr(a, n), getattr(b, n)) for n in names)
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(_same(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(_same, a, b)) and type(a) is type(b)
    return bool(a == b) and type(a) is type(b)


@pytest.mark.parametrize("description", [example(), SceneDescription()], ids=["full", "empty"])
def test_round_trip(description: SceneDescription, tmp_path: Path) -> None:
    path = tmp_path / "scene.vernier"
    save(description, path)
    assert _same(_plain(load(path)), _plain(description))
    assert [item.name for item in tmp_path.iterdir()] == ["scene.vernier"]


def _plain(description: SceneDescription) -> SceneDescription:
    """Flags as the integers that they are stored as."""
    description.world.visibility = int(description.world.visibility)
    for light in description.lights:
        light.visibility = int(light.visibility)
    return description


def test_large_arrays_keep_every_bit(tmp_path: Path, rng: np.random.Generator) -> None:
    description = example()
    pixels = rng.standard_normal((37, 53, 3)).astype(np.float32)
    description.images[0].pixels = pixels
    save(description, tmp_path / "scene")
    np.testing.assert_array_equal(load(tmp_path / "scene").images[0].pixels, pixels)  # type: ignore[arg-type]


def test_an_invalid_description_is_not_written(tmp_path: Path) -> None:
    description = example()
    description.film.width = 0
    with pytest.raises(DescriptionError, match="the film: width"):
        save(description, tmp_path / "scene")
    assert list(tmp_path.iterdir()) == []


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        load(tmp_path / "none")


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("stored") / "scene"
    save(example(), path)
    return path.read_bytes()


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04", b"\x93NUMPY\x01\x00"])
def test_other_files(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "scene"
    path.write_bytes(content)
    with pytest.raises(StorageError, match=r"scene is damaged or no scene of Vernier's"):
        load(path)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(cut=st.floats(0.0, 0.999))
def test_truncated_files(stored: bytes, tmp_path_factory: Any, cut: float) -> None:
    path = tmp_path_factory.mktemp("cut") / "scene"
    path.write_bytes(stored[: int(cut * len(stored))])
    with pytest.raises(StorageError) as caught:
        load(path)
    assert "\n" not in str(caught.value)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(place=st.floats(0.0, 0.999), value=st.integers(0, 255))
def test_damaged_bytes_never_load_as_another_scene(
    stored: bytes, tmp_path_factory: Any, place: float, value: int
) -> None:
    """A flipped byte is found by the archive's checksum, or does not matter."""
    damaged = bytearray(stored)
    damaged[int(place * len(stored))] = value
    path = tmp_path_factory.mktemp("damaged") / "scene"
    path.write_bytes(damaged)
    try:
        found = load(path)
    except StorageError:
        return
    assert _same(_plain(found), _plain(example()))


def _write(path: Path, header: Any, data: np.ndarray | None = None) -> None:
    raw = np.frombuffer(json.dumps(header).encode(), np.uint8)
    with path.open("wb") as file:
        np.savez(file, header=raw, data=np.zeros(0, np.uint8) if data is None else data)


def _with_mesh(array: Any) -> Any:
    """A header whose instances' meshes are an array."""
    scene = {"instances": {"mesh": {"array": array}}}
    return {"format": FORMAT, "version": 1, "scene": scene}


@pytest.mark.parametrize(
    ("header", "pattern"),
    [
        ({"format": "other"}, "is no scene of Vernier's"),
        ([], "is no scene of Vernier's"),
        ({"format": FORMAT, "version": 99, "scene": {}}, "version 99.*reads version 1"),
        ({"format": FORMAT, "version": 1}, "damaged"),
        ({"format": FORMAT, "version": 1, "scene": {"lamps": []}}, "SceneDescription is malformed"),
        ({"format": FORMAT, "version": 1, "scene": {"film": {"width": 0}}}, "breaks a rule"),
        (
            _with_mesh(["int32", [4], 0]),
            "reaches beyond the data",
        ),
        (
            _with_mesh(["object", [1], 0]),
            "an array is malformed",
        ),
    ],
)  # fmt: skip
def test_malformed_headers(header: Any, pattern: str, tmp_path: Path) -> None:
    _write(tmp_path / "scene", header)
    with pytest.raises(StorageError, match=pattern):
        load(tmp_path / "scene")
