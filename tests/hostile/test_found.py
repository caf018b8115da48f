"""Files that faults were found by, kept as they were: generated scenes, and damaged ones."""

from __future__ import annotations

from pathlib import Path

import pytest

import engine_core
from engine_core import storage

FOUND = sorted((Path(__file__).parent / "found").glob("*.vernier"))
REFUSED = sorted((Path(__file__).parent / "found" / "refused").glob("*.vernier"))


@pytest.mark.parametrize("path", FOUND, ids=[path.stem for path in FOUND])
def test_scenes_that_were_at_fault_are_drawn(path: Path) -> None:
    compiled = engine_core.compile(storage.load(path), threads=1)
    session = engine_core.Session(compiled, {"samples": 1, "threads": 1}, ["Combined"])
    session.start()
    while not session.wait(10.0):
        pass
    assert session.error_message == ""


@pytest.mark.parametrize("path", REFUSED, ids=[path.stem for path in REFUSED])
def test_files_that_were_taken_by_mistake_are_refused(path: Path) -> None:
    with pytest.raises(storage.StorageError) as refusal:
        storage.load(path)
    assert "\n" not in str(refusal.value)
