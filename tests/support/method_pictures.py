"""Pictures of named scenes by any method, and the path tracer's, which they are held against."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from scenes import Array, pictures

Builder = Callable[[], Any]


@dataclass(frozen=True)
class MethodPictures:
    """`samples` per pixel by integrator; `seeds` independent pictures each."""

    scenes: Mapping[str, Builder]
    samples: Mapping[str, int]
    seeds: int = 8
    _references: dict[str, Array] = field(default_factory=dict)

    def shots(self, name: str, integrator: str, **settings: Any) -> Array:
        samples = self.samples[integrator]
        return pictures(
            self.scenes[name](), self.seeds, integrator=integrator, samples=samples, **settings
        )

    def reference(self, name: str) -> Array:
        """Path traced with at most five bounces."""
        if name not in self._references:
            self._references[name] = self.shots(name, "PATH", max_bounces=5)
        return self._references[name]
