"""Finding the compiled core."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType


class CoreMissingError(Exception):
    """The core cannot be used; the message says why, in one sentence."""


def core() -> ModuleType:
    """Returns the package `engine_core`. Raises CoreMissingError."""
    _find_sources()
    try:
        module = importlib.import_module("engine_core")
    except Exception as error:  # whatever a compiled module raises when it is loaded
        raise CoreMissingError(f"Vernier's core cannot be loaded: {error}") from error
    if not hasattr(module, "Session"):
        raise CoreMissingError(
            "Vernier's core is not installed: the Python package engine_core holds no engine"
        )
    return module


def has_core() -> bool:
    """Whether `core` would succeed."""
    try:
        core()
    except CoreMissingError:
        return False
    return True


def _find_sources() -> None:
    """In a checkout that is not installed, the package's sources describe scenes at least."""
    if "engine_core" in sys.modules and hasattr(sys.modules["engine_core"], "Session"):
        return
    if importlib.util.find_spec("engine_core") is None or _is_namespace():
        sources = Path(__file__).resolve().parent.parent / "engine_core" / "python"
        if sources.is_dir() and str(sources) not in sys.path:
            sys.path.append(str(sources))
            importlib.invalidate_caches()


def _is_namespace() -> bool:
    """Whether `engine_core` is only a folder of that name on the path."""
    spec = importlib.util.find_spec("engine_core")
    return spec is not None and spec.origin is None
