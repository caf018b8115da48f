"""Saved scenes, cut short or changed anywhere, are refused in a sentence or are scenes."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bidirectional_scenes import build
from engine_core.storage import StorageError, load, save

import engine_core


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("scenes") / "scene.vernier"
    save(build("principled", "sky").description, path)
    return path.read_bytes()


def read(data: bytes, folder: Path) -> bool:
    """Whether the file is a scene; it is then compiled. Anything but a sentence is an error."""
    path = folder / "damaged.vernier"
    path.write_bytes(data)
    try:
        description = load(path)
    except StorageError:
        return False
    try:
        engine_core.compile(description, threads=1)
    except (ValueError, TypeError, RuntimeError, MemoryError):
        return False
    return True


def test_files_cut_short(saved: bytes, tmp_path: Path) -> None:
    for length in np.linspace(0, len(saved) - 1, 100).astype(int):
        assert not read(saved[:length], tmp_path)


def test_files_with_changed_bytes(saved: bytes, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    for _ in range(200):
        data = bytearray(saved)
        for at in rng.integers(0, len(data), rng.integers(1, 8)):
            data[at] = rng.integers(0, 256)
        read(bytes(data), tmp_path)


def places(tree: Any, found: list[tuple[Any, Any]]) -> list[tuple[Any, Any]]:
    """All (container, key) of a JSON tree."""
    keys = tree.keys() if isinstance(tree, dict) else range(len(tree))
    for key in list(keys):
        found.append((tree, key))
        if isinstance(tree[key], dict | list):
            places(tree[key], found)
    return found


def test_files_whose_header_says_something_else(saved: bytes, tmp_path: Path) -> None:
    """The archive is whole and its JSON is well-formed: values are what they should not be."""
    rng = np.random.default_rng(4)
    with np.load(io.BytesIO(saved)) as archive:
        header, data = archive["header"].tobytes().decode(), archive["data"]
    values = [None, 0, -1, 2**31, 2**63, 1e308, float("nan"), "", "x", [], {}, [0], True,
              {"array": ["float32", [2**40], 0]}, {"link": [0, "BSDF"]}, {"link": []}]  # fmt: skip
    for _ in range(300):
        tree = json.loads(header)
        nodes = places(tree["scene"], [])
        for at in rng.integers(0, len(nodes), rng.integers(1, 4)):
            container, key = nodes[at]
            container[key] = values[rng.integers(0, len(values))]
        file = io.BytesIO()
        np.savez(file, header=np.frombuffer(json.dumps(tree).encode(), np.uint8), data=data)
        read(file.getvalue(), tmp_path)
