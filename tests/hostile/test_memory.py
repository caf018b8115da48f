"""Memory that runs out ends a compilation or a render with one sentence, and nothing else.

In a process of its own, whose address space is limited to a little more than it has: by so many
amounts that the allocation which fails is another one each time. Only the C library itself ends a
process that has less than a thread's own variables need.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

import engine_core

INTEGRATORS = [
    identifier
    for parameter in engine_core.parameters()
    if parameter.name == "integrator"
    for identifier, *_ in parameter.items
]

CODE = """
import ctypes, json, resource, sys
from pathlib import Path
import numpy as np
sys.path[:0] = sys.argv[1:3]
from bidirectional_scenes import lamp, room
from scenes import diffuse, sphere
import engine_core

def scene(rings):
    built = room()
    lamp("AREA", built, size_x=0.8, size_y=0.5)
    built.add(sphere(0.5, (0, 0, 1), rings=rings), diffuse(0.5))
    return built.description

def attempt(description, integrator, threads=2):
    try:
        scene = engine_core.compile(description, threads=threads)
        settings = {"threads": 2, "samples": 2, "integrator": integrator}
        session = engine_core.Session(scene, settings, ["Combined", "Normal"])
        session.start()
        if not session.wait(60.0):
            return "did not end"
        return session.error_message or "rendered"
    except (MemoryError, RuntimeError) as error:
        return f"{type(error).__name__}: {error}"

def occupied():
    return int(Path("/proc/self/statm").read_text().split()[0]) * 4096

description, _ = scene(300), attempt(scene(4), "PATH")  # what is kept for the process is there
for integrator, megabytes in json.loads(sys.argv[3]):
    ctypes.CDLL(None).malloc_trim(0)  # else what was freed before is room enough
    resource.setrlimit(resource.RLIMIT_AS, (occupied() + int(megabytes * 2**20), -1))
    answer = attempt(description, integrator)
    resource.setrlimit(resource.RLIMIT_AS, (-1, -1))
    print(json.dumps([integrator, megabytes, answer]))
print(json.dumps(["at last", 0, attempt(scene(4), "PATH")]))
"""

#: A plan that needs more than there is, made by the first thread of a render. Then threads that
#: there is no room for: each asks for megabytes of stack.
IN_THREADS = (
    CODE.partition("description, _ =")[0]
    + """
small = engine_core.compile(scene(4), threads=2)
many = room()
for i in range(64):
    many.add(sphere(0.1, (0, 0, 1), rings=4), diffuse(0.5))
many_meshes = many.description
for integrator in json.loads(sys.argv[3]):
    settings = {"integrator": integrator, "threads": 1, "samples": 2}
    session = engine_core.Session(small, settings, ["Combined"])
    resource.setrlimit(resource.RLIMIT_AS, (occupied() + 9 * 2**20, -1))
    session.start()
    ended = session.wait(60.0)
    resource.setrlimit(resource.RLIMIT_AS, (-1, -1))
    answer = session.error_message or ("rendered" if ended else "did not end")
    print(json.dumps([integrator, 9, answer]))
resource.setrlimit(resource.RLIMIT_AS, (occupied() + 48 * 2**20, -1))
answer = attempt(many_meshes, "PATH", threads=64)
resource.setrlimit(resource.RLIMIT_AS, (-1, -1))
print(json.dumps(["64 threads", 48, answer]))
"""
)

#: What may be said: of memory, or of what a thread needs of it.
SENTENCES = {
    "rendered",
    "MemoryError: there is not enough memory for this render",
    "there is not enough memory for this render",
    "RuntimeError: Resource temporarily unavailable",
}


def answers(code: str, attempts: object) -> list[tuple[str, float, str]]:
    tests = Path(__file__).parents[1]
    done = subprocess.run(
        [sys.executable, "-c", code, tests / "support", tests.parent, json.dumps(attempts)],
        env={**os.environ, "MALLOC_ARENA_MAX": "1"},  # arenas set room aside that no limit reaches
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, f"{done.returncode}: {done.stdout[-500:]} {done.stderr[-1000:]}"
    return [tuple(json.loads(line)) for line in done.stdout.splitlines()]


def test_memory_that_runs_out_is_told_in_a_sentence() -> None:
    attempts = [
        (INTEGRATORS[number * 5 % len(INTEGRATORS)], round(float(megabytes), 3))
        for number, megabytes in enumerate(np.geomspace(6.0, 96.0, 11))
    ]
    found = answers(CODE, attempts)
    assert {answer for *_, answer in found} <= SENTENCES, found
    assert sum("memory" in answer for *_, answer in found) >= 3, found
    assert found[-1][2] == "rendered", "memory that is there again is of no use"


def test_threads_that_have_no_memory_end_with_a_sentence() -> None:
    found = answers(IN_THREADS, INTEGRATORS)
    assert {answer for *_, answer in found} <= SENTENCES, found
