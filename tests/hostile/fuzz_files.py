"""Coverage-guided fuzzing of saved scenes: reading, compiling and rendering them.

Like libFuzzer: files that make the program take steps that no file before made it take are kept,
and new ones are made by changing those. Saved scenes are archives with checksums of a JSON text and
of arrays, so that bytes changed anywhere would only tell that archives are checked. What is
changed is therefore the tree of values and the arrays' bytes, and now and then the archive itself.

A report of a sanitizer ends the process; the file at fault is then the one that is left in the
folder. So is one that raises what it should not, or whose render does not end. `scripts/sanitize
files` runs this with the build that it needs.
"""

from __future__ import annotations

import argparse
import copy
import io
import json
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from types import CodeType
from typing import Any

import numpy as np
from bidirectional_scenes import LIGHTS, MATERIALS, build
from engine_core.storage import StorageError, load, save

import engine_core

INTEGRATORS = [
    identifier
    for parameter in engine_core.parameters()
    if parameter.name == "integrator"
    for identifier, *_ in parameter.items
]
SETTINGS = {"threads": 1, "samples": 1, "max_bounces": 3, "transparent_bounces": 4,
            "whitted_depth": 3, "chain_length": 64, "photon_paths": 256, "global_photons": 256,
            "caustic_photons": 256, "final_gather_rays": 1, "time_limit": 2.0}  # fmt: skip
MOST_PIXELS = 64
#: Longest that reading, compiling and rendering may take, seconds.
PATIENCE = 60.0
FLOATS = np.array([0, -0.0, 1, -1, 1e-45, 1e-38, 1e-20, 1e-6, 1e6, 1e18, 1e30, 3.4e38, -3.4e38,
                   np.inf, -np.inf, np.nan], np.float32)  # fmt: skip
INTEGERS = [0, 1, -1, 2, 3, 7, 255, 256, 65535, 65536, 2**31 - 1, -(2**31), 2**32 - 1]
VALUES: list[Any] = [None, True, False, "", "x", [], {}, [0], 1e308, -1e308, float("nan"), 2**63,
                     {"array": ["float32", [2**40], 0]}, {"link": [0, "BSDF"]},
                     *INTEGERS, *(float(x) for x in FLOATS)]  # fmt: skip


@dataclass(frozen=True)
class Saved:
    """A file's header, as text, and its arrays' bytes."""

    header: str
    data: bytes

    def archive(self) -> bytes:
        file = io.BytesIO()
        np.savez(file, header=np.frombuffer(self.header.encode(), np.uint8),
                 data=np.frombuffer(self.data, np.uint8))  # fmt: skip
        return file.getvalue()

    @staticmethod
    def of(path: Path) -> Saved:
        with np.load(path) as archive:
            return Saved(archive["header"].tobytes().decode(), archive["data"].tobytes())


def places(tree: Any, found: list[tuple[Any, Any]]) -> list[tuple[Any, Any]]:
    """All (container, key) of a JSON tree."""
    for key in list(tree.keys()) if isinstance(tree, dict) else range(len(tree)):
        found.append((tree, key))
        if isinstance(tree[key], dict | list):
            places(tree[key], found)
    return found


class Mutator:
    """Makes files of files."""

    def __init__(self, rng: np.random.Generator, corpus: list[Saved]) -> None:
        self._rng = rng
        self._corpus = corpus

    def pick(self, items: Any) -> Any:
        return items[self._rng.integers(len(items))]

    def next(self) -> bytes:
        saved: Saved = self.pick(self._corpus)
        kind = self._rng.random()
        if kind < 0.03:
            return self._bytes_changed(saved.archive())
        data = saved.data
        if kind < 0.4:
            data = self._numbers_changed(data)
        header = saved.header if kind >= 0.25 and kind < 0.4 else self._tree_changed(saved.header)
        return Saved(header, data).archive()

    def _bytes_changed(self, archive: bytes) -> bytes:
        changed = bytearray(archive)
        for at in self._rng.integers(len(changed), size=self._rng.integers(1, 6)):
            changed[at] = self._rng.integers(256)
        return bytes(changed[: self._rng.integers(len(changed))] if self.pick((0, 1)) else changed)

    def _numbers_changed(self, data: bytes) -> bytes:
        """Some of the arrays' elements, all of which have four bytes but pixels."""
        words = np.frombuffer(data[: len(data) // 4 * 4], np.uint32).copy()
        if len(words) == 0:
            return data
        for at in self._rng.integers(len(words), size=self._rng.integers(1, 12)):
            kind = self._rng.integers(4)
            if kind == 0:
                words[at : at + 1].view(np.float32)[0] = self.pick(FLOATS)
            elif kind == 1:
                words[at] = self.pick(INTEGERS) % 2**32
            elif kind == 2:
                words[at] ^= np.uint32(1) << np.uint32(self._rng.integers(32))
            else:
                words[at] = words[self._rng.integers(len(words))]
        return words.tobytes() + data[len(words) * 4 :]

    def _tree_changed(self, header: str) -> str:
        tree = json.loads(header)
        for _ in range(self._rng.integers(1, 5)):
            found = places(tree["scene"], []) if isinstance(tree.get("scene"), dict) else []
            if not found:
                break
            self._change(*self.pick(found), found)
        return json.dumps(tree)

    def _change(self, container: Any, key: Any, found: list[tuple[Any, Any]]) -> None:
        value, kind = container[key], self._rng.integers(6)
        if kind == 0:
            container[key] = self.pick(VALUES)
        elif kind == 1:
            del container[key]
        elif kind == 2 and isinstance(container, list) and len(container) < 64:
            container.append(copy.deepcopy(value))
        elif kind == 3:
            self._splice(container, key)
        elif isinstance(value, bool) or value is None:
            container[key] = not value
        elif isinstance(value, int):
            container[key] = self.pick((value + 1, value - 1, -value, 2 * value, *INTEGERS))
        elif isinstance(value, float):
            container[key] = self.pick((value * 10, -value, value / 1000, *map(float, FLOATS)))
        elif isinstance(value, str):
            texts = [c[k] for c, k in found if isinstance(c[k], str)]
            container[key] = self.pick(texts)

    def _splice(self, container: Any, key: Any) -> None:
        """What another file has in a place of the same name."""
        other = json.loads(self.pick(self._corpus).header)
        alike = [c[k] for c, k in places(other["scene"], []) if k == key]
        if alike:
            container[key] = self.pick(alike)


class LinesMet:
    """Lines of the core's Python modules that were never run before."""

    def __init__(self) -> None:
        self.new = 0
        folder = str(Path(str(engine_core.__file__)).parent)

        def line(code: CodeType, _number: int) -> Any:
            self.new += code.co_filename.startswith(folder)
            return sys.monitoring.DISABLE

        tool = sys.monitoring.COVERAGE_ID
        sys.monitoring.use_tool_id(tool, "fuzz")
        sys.monitoring.register_callback(tool, sys.monitoring.events.LINE, line)
        sys.monitoring.set_events(tool, sys.monitoring.events.LINE)

    def take(self) -> int:
        taken, self.new = self.new, 0
        return taken


def check_sentence(text: str) -> None:
    assert text, "nothing is said"
    assert "\n" not in text, text


def execute(path: Path, integrator: str) -> str:
    """Reads, compiles and renders. Returns how far it came; raises AssertionError."""
    try:
        description = load(path)
    except StorageError as error:
        check_sentence(str(error))
        return "refused"
    film = description.film
    if film.width * film.height > MOST_PIXELS or description.camera is None:
        return "read"
    try:
        scene = engine_core.compile(description, threads=1)
        session = engine_core.Session(scene, {**SETTINGS, "integrator": integrator}, ["Combined"])
    except (ValueError, RuntimeError, MemoryError) as error:
        check_sentence(str(error))
        return "refused later"
    session.start()
    assert session.wait(PATIENCE), "the render did not end"
    picture = session.read("Combined", 0, 0, scene.width, scene.height)
    assert not np.isnan(picture).any(), "a value is no number"
    return "rendered"


def seeds(folder: Path) -> list[Saved]:
    """Every material and every light of the tests' scenes."""
    found = []
    path = folder / "seed.vernier"
    scenes = [(material, "area") for material in MATERIALS]
    scenes += [("diffuse", light) for light in LIGHTS]
    for material, light in scenes:
        builder = build(material, light)
        film = builder.description.film
        film.width, film.height, film.crop = 4, 3, (0, 0, 4, 3)
        save(builder.description, path)
        found.append(Saved.of(path))
    path.unlink()
    return found


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path, help="where files are put")
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    path = options.folder / "at_fault.vernier"
    corpus = seeds(options.folder)
    first = len(corpus)
    rng = np.random.default_rng(options.seed)
    mutator, lines = Mutator(rng, corpus), LinesMet()
    outcomes: dict[str, int] = {}
    steps = 0
    end = time.monotonic() + 60.0 * options.minutes
    for number in range(sys.maxsize):
        if time.monotonic() > end:
            break
        data = corpus[number].archive() if number < first else mutator.next()
        path.write_bytes(data)
        begun = time.monotonic()
        outcome = execute(path, INTEGRATORS[int(rng.integers(len(INTEGRATORS)))])
        assert time.monotonic() - begun < PATIENCE, "it takes too long"
        outcomes[outcome] = outcomes.get(outcome, 0) + 1
        new = engine_core.probe.take_new_steps() + lines.take()
        steps += new
        if new and number >= first and outcome != "refused":
            corpus.append(Saved.of(path))
    path.unlink(missing_ok=True)
    told = ", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items()))
    print(f"{sum(outcomes.values())} files: {told}; {len(corpus)} kept, {steps} steps met")


if __name__ == "__main__":
    main()
