"""Renders that stop at an accuracy: when they do, what they claim, and that nothing is biased."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scenes import Array, soft_scene

import engine_core

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def soft(size: int = 32) -> Any:
    return engine_core.compile(soft_scene(size).description, threads=2)


def rendered(scene: Any, **settings: Any) -> Any:
    session = engine_core.Session(
        scene, {"samples": 1 << 16, "threads": 2, **settings}, ["Combined", "Error"]
    )
    session.start()
    while not session.wait(10.0):
        pass
    assert session.error_message == ""
    return session


def luminance(session: Any, scene: Any) -> Array:
    color = np.asarray(session.read("Combined", 0, 0, scene.width, scene.height), np.float64)
    return np.asarray(color[..., :3] @ LUMINANCE)


@pytest.mark.parametrize("integrator", ["PATH", "BDPT"])
@pytest.mark.parametrize("target", [8.0, 4.0])
def test_a_render_ends_at_its_target(integrator: str, target: float) -> None:
    progress = rendered(soft(), integrator=integrator, target_error=target).poll(True)
    assert progress.ending == "target"
    assert 0.4 * target / 100 < progress.error <= target / 100
    assert 16 <= progress.samples < 1 << 16


def test_what_comes_first_ends_a_render() -> None:
    scene = soft(8)
    assert rendered(scene, samples=20, target_error=1e-3).poll().ending == "samples"
    assert rendered(scene, samples=20).poll().ending == "samples"
    ended = rendered(scene, samples=1 << 24, time_limit=0.2, target_error=1e-3).poll()
    assert ended.ending == "time"
    session = engine_core.Session(scene, {"samples": 1 << 24, "threads": 2}, ["Combined"])
    assert session.poll().ending == ""
    session.start()
    session.cancel()
    while not session.wait(10.0):
        pass
    assert session.poll().ending == "cancel"


def test_a_target_s_picture_does_not_depend_on_the_threads() -> None:
    scene = soft(40)
    pictures = [
        luminance(rendered(scene, target_error=25.0, threads=threads), scene)
        for threads in (1, 2, 5)
    ]
    assert np.array_equal(pictures[0], pictures[1])
    assert np.array_equal(pictures[0], pictures[2])


def test_too_few_batches_certify_nothing() -> None:
    """However generous the target, sixteen batches are needed to tell."""
    progress = rendered(soft(8), target_error=1000.0).poll()
    assert progress.ending == "target"
    assert progress.samples >= 16


def test_tiles_that_end_sooner_keep_no_picture_from_its_target() -> None:
    """Where every tile has few batches, one that stopped must not make all others go on."""
    scene = soft(96)
    for target in (16.0, 25.0):
        uneven, even = (
            rendered(scene, integrator="PATH", target_error=target, adaptive=adaptive).poll()
            for adaptive in (True, False)
        )
        assert uneven.ending == even.ending == "target"
        assert uneven.samples <= 1.1 * even.samples


def test_stopping_at_a_target_biases_neither_picture_nor_claim() -> None:
    """200 small renders: their mean is the truth, and 95 in 100 pixels lie within their error."""
    scene = soft(12)
    truth = luminance(rendered(scene, samples=32768, seed=10_000), scene)
    floor = 0.01 * truth.mean()
    values, inside = [], []
    for seed in range(200):
        session = rendered(scene, target_error=60.0, seed=seed)
        assert session.poll().ending == "target"
        value = luminance(session, scene)
        error = np.asarray(session.read("Error", 0, 0, 12, 12), np.float64)[..., 0]
        inside.append(abs(value - truth) <= error * np.maximum(value, floor))
        values.append(value)
    means = np.array(values).mean(axis=(1, 2))
    z = (means.mean() - truth.mean()) / (means.std(ddof=1) / math.sqrt(len(means)))
    assert abs(z) < 4.0
    shares = np.mean(inside, axis=(1, 2))
    assert 0.93 < shares.mean() < 0.985
