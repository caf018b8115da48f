"""Vernier's rendering core: describe a scene, compile it, render it.

>>> scene = engine_core.compile(description)
>>> session = engine_core.Session(scene, {"samples": 64}, ["Combined"])
>>> session.start()
>>> session.wait(60.0)
>>> picture = session.read("Combined", 0, 0, scene.width, scene.height)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import _loader
from ._loader import CoreUnavailableError
from .description import Camera, Film, SceneDescription
from .tables import Parameter, PassInfo, parameters_from, passes_from
from .validation import DescriptionError, validate, validate_view

_core = _loader.load()

Scene = _core.Scene
Session = _core.Session
Progress = _core.Progress
probe = _core.probe
start_recording = _core.start_recording
stop_recording = _core.stop_recording
replay = _core.replay

#: The instruction set that the core in use was compiled for: v2, v3 or v4.
INSTRUCTION_SET: str = _core.__name__.rpartition("_")[2]


def parameters() -> list[Parameter]:
    """The settings of a render, each declared once."""
    return parameters_from(_core.parameter_rows())


def passes() -> list[PassInfo]:
    """The passes that a render can make."""
    return passes_from(_core.pass_rows())


def compile(
    description: SceneDescription,
    threads: int = 0,
    keep_uv: bool = False,
    cancelled: Callable[[], bool] | None = None,
    consume: bool = False,
    interactive: bool = False,
    previous: Any = None,
) -> Any:
    """Validates and compiles a description to an immutable `Scene`.

    `threads` 0: as many as the machine has. `keep_uv`: the UV pass will be asked for.
    `cancelled` is polled now and then. `consume` takes the meshes and images out of `description`
    once they have been read, so that they need no memory while the rest is built. Raises
    DescriptionError (a ValueError) or ValueError naming what is wrong, RuntimeError when Embree
    fails or the call is cancelled, MemoryError.

    `interactive`: for a scene that will be edited while it is looked at. Its hierarchy is built
    sooner and traversed slower, and it may be the `previous` one of a later call, which then shares
    with it what the edit left alone: images that are the same objects, materials whose graphs are
    equal, and all geometry when the meshes are the same objects in the same places. The scene's
    `compiled` tells what was made. What is shared must not have been changed in place.
    """
    validate(description)
    if description.camera is None:
        raise DescriptionError("the scene has no camera")
    return _core.compile(description, threads, keep_uv, cancelled, consume, interactive, previous)


def with_view(scene: Any, camera: Camera, film: Film) -> Any:
    """The same `Scene` through another camera onto another film. Raises DescriptionError."""
    validate_view(camera, film)
    return scene.with_view(camera, film)


__all__ = [
    "INSTRUCTION_SET",
    "CoreUnavailableError",
    "DescriptionError",
    "Parameter",
    "PassInfo",
    "Progress",
    "Scene",
    "SceneDescription",
    "Session",
    "compile",
    "parameters",
    "passes",
    "probe",
    "replay",
    "start_recording",
    "stop_recording",
    "validate",
    "validate_view",
    "with_view",
]
