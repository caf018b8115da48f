"""Renders a case by a method and judges it."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from extreme_cases.case import Case, Same
from extreme_judge import Shots, Verdict, judge
from extreme_methods import method
from scenes import SceneBuilder

import engine_core

#: Longest that one render may take before it counts as endless, seconds.
PATIENCE = 600.0


@dataclass(frozen=True)
class Effort:
    """How many independent pictures are made, and how many samples each has of the case's."""

    pictures: int = 6
    share: float = 1.0


@dataclass(frozen=True)
class Result:
    case: Case
    integrator: str
    verdict: Verdict
    seconds: float
    picture: np.ndarray
    samples: float


def shoot(
    builder: SceneBuilder, integrator: str, settings: dict[str, object], pictures: int
) -> Shots:
    """Renders independent pictures; never raises for what the renderer does."""
    shots, dropped, samples = [], 0, 0.0
    try:
        scene = engine_core.compile(builder.description, threads=2)
        for seed in range(pictures):
            options = {"threads": 2, **settings, "integrator": integrator, "seed": seed}
            session = engine_core.Session(scene, options, ["Combined"])
            session.start()
            begun = time.monotonic()
            while not session.wait(1.0):
                if time.monotonic() - begun > PATIENCE:
                    session.cancel()
                    return Shots(np.zeros((1, 1, 1, 3)), 0, 0, "the render did not end")
            if session.error_message:
                return Shots(np.zeros((1, 1, 1, 3)), 0, 0, session.error_message)
            progress = session.poll()
            dropped += int(progress.non_finite)
            samples += progress.samples * scene.width * scene.height
            picture = session.read("Combined", 0, 0, scene.width, scene.height)
            shots.append(np.asarray(picture, np.float64)[..., :3])
    except (ValueError, RuntimeError, MemoryError) as error:
        return Shots(np.zeros((1, 1, 1, 3)), 0, 0, f"{type(error).__name__}: {error}")
    return Shots(np.stack(shots), samples, dropped)


class Runner:
    """Keeps the pictures that many cases are compared with."""

    def __init__(self, effort: Effort) -> None:
        self.effort = effort
        self._others: dict[object, Shots] = {}

    def settings(self, case: Case, integrator: str) -> dict[str, object]:
        settings = {**case.settings, **method(integrator).settings}
        return {**settings, "samples": max(1, round(case.samples * self.effort.share))}

    def run(self, case: Case, integrator: str) -> Result:
        begun = time.monotonic()
        count = self.effort.pictures if case.noisy else 1
        shots = shoot(case.build(), integrator, self.settings(case, integrator), count)
        verdict = judge(
            case.expects,
            shots,
            lambda expected: self.other(expected, case, integrator),
            method(integrator).blur if case.blurred else method(integrator).bias,
        )
        picture = shots.pictures.mean(axis=0)
        return Result(case, integrator, verdict, time.monotonic() - begun, picture, shots.samples)

    def other(self, expected: Same, case: Case, integrator: str) -> Shots:
        """With other seeds where the scene and the method are the same."""
        chosen = "PATH" if expected.of_paths else integrator
        settings = self.settings(case, chosen)
        key = (repr(expected.other), chosen, tuple(sorted(settings.items())))
        if key not in self._others:
            self._others[key] = shoot(expected.other(), chosen, settings, self.effort.pictures)
        return self._others[key]
