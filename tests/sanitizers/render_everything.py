"""Renders by every method on several threads, while the host does all that it may do meanwhile.

`scripts/sanitize threads` runs this with a build that reports races. Every scene brings threads
together elsewhere: splats, photon maps, chains, shared light paths, images, light trees, adaptive
tiles, saved states.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

from bidirectional_scenes import build
from scenes import SceneBuilder

import engine_core

THREADS = 4
INTEGRATORS = [
    identifier
    for parameter in engine_core.parameters()
    if parameter.name == "integrator"
    for identifier, *_ in parameter.items
]
SCENES = [("principled", "sky"), ("glass", "area"), ("diffuse", "many")]
PASSES = ["Combined", "Normal", "DiffDir", "DiffInd"]


def settings(integrator: str, **more: Any) -> dict[str, Any]:
    return {"integrator": integrator, "threads": THREADS, "samples": 4, "max_bounces": 4,
            "chain_length": 256, "photon_paths": 4096, "global_photons": 4096,
            "caustic_photons": 4096, "final_gather_rays": 2, **more}  # fmt: skip


def watch(session: Any, scene: Any) -> None:
    """All that a host does while the threads are at work."""
    session.start()
    while not session.wait(0.01):
        session.poll(True)
        session.take_tiles()
        session.read("Combined", 0, 0, scene.width, scene.height)
    assert session.error_message == "", session.error_message


def render(scene: Any, integrator: str) -> None:
    passes = [p.name for p in engine_core.passes() if p.name in PASSES]
    watch(engine_core.Session(scene, settings(integrator), passes), scene)
    target = settings(integrator, target_error=20.0, adaptive=1, samples=64)
    watch(engine_core.Session(scene, target, ["Combined"]), scene)
    limited = settings(integrator, time_limit=0.05, samples=1 << 16)
    watch(engine_core.Session(scene, limited, ["Combined"]), scene)
    cancelled = engine_core.Session(scene, settings(integrator, samples=1 << 16), ["Combined"])
    cancelled.start()
    with tempfile.TemporaryDirectory() as folder:
        cancelled.wait(0.02)
        cancelled.save(str(Path(folder, "state")), "scene")
    cancelled.cancel()
    assert cancelled.wait(120.0)


def compiled(builder: SceneBuilder) -> Any:
    film = builder.description.film
    film.width, film.height, film.crop = 40, 36, (0, 0, 40, 36)
    return engine_core.compile(builder.description, threads=THREADS)


def main() -> None:
    chosen = sys.argv[1:] or INTEGRATORS
    for material, light in SCENES:
        scene = compiled(build(material, light))
        for integrator in chosen:
            render(scene, integrator)
            print(f"{material}, {light} by {integrator}", flush=True)


if __name__ == "__main__":
    main()
