"""Imports the core compiled for this processor, and opens Embree for it."""

from __future__ import annotations

import importlib
import importlib.util
import os
from pathlib import Path
from types import ModuleType

LEVELS = ("v4", "v3", "v2")


class CoreUnavailableError(ImportError):
    """The core cannot run here; the message says why in one sentence."""


def _available_levels() -> list[str]:
    folder = Path(__file__).parent
    return [level for level in LEVELS if any(folder.glob(f"_core_{level}.*"))]


def _choose_level() -> str:
    best = importlib.import_module("engine_core._cpu").best_level()
    usable = [level for level in LEVELS if best and level <= best]
    forced = os.environ.get("VERNIER_ISA", "")
    if forced:
        if forced not in usable or forced not in _available_levels():
            raise CoreUnavailableError(
                f"VERNIER_ISA={forced}: that build is not here or this processor cannot run it"
            )
        return forced
    for level in _available_levels():
        if level in usable:
            return level
    raise CoreUnavailableError(
        "this processor is too old: x86-64-v2 (SSE4.2) is the least that Vernier runs on"
    )


def _embree_path() -> Path:
    """The Embree library within the installed `embreex` wheel."""
    spec = importlib.util.find_spec("embreex")
    if spec is None or spec.origin is None:
        raise CoreUnavailableError("the package embreex, which carries Embree, is not installed")
    package = Path(spec.origin).parent
    patterns = ("libembree4*.so*", "libembree4*.dylib", "embree4*.dll")
    for folder in (package.parent / "embreex.libs", package / ".dylibs", package):
        for pattern in patterns:
            found = sorted(folder.glob(pattern))
            if found:
                return found[0]
    raise CoreUnavailableError(f"no Embree library was found beside {package}")


def load() -> ModuleType:
    """The compiled core. Raises CoreUnavailableError."""
    level = _choose_level()
    try:
        core = importlib.import_module(f"engine_core._core_{level}")
        core.load_embree(str(_embree_path()))
    except CoreUnavailableError:
        raise
    except (ImportError, RuntimeError) as error:
        raise CoreUnavailableError(f"the core for x86-64-{level} does not load: {error}") from error
    return core
