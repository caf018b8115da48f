"""The viewport's parts that need no window: views, and the thread that makes pictures of them."""

from __future__ import annotations

import copy
import gc
import threading
import time
import weakref
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from engine_core.description import SceneDescription
from scenes import SceneBuilder, background, diffuse, sphere

from addon.viewport.pictures import PictureMaker, Request
from addon.viewport.view import View

VALUES: dict[str, bool | int | float | str] = {"samples": 3, "threads": 1, "pixel": 1}


def perspective(width: int, height: int, distance: float = 5.0) -> View:
    """A view along -z from above the origin, square pixels."""
    near, far, half = 0.1, 100.0, 0.04
    tall = half * height / width
    projection = [
        (near / half, 0, 0, 0),
        (0, near / tall, 0, 0),
        (0, 0, -(far + near) / (far - near), -2 * far * near / (far - near)),
        (0, 0, -1, 0),
    ]
    view = np.eye(4)
    view[2, 3] = -distance
    flat = tuple(float(x) for row in projection for x in row)
    return View(width, height, tuple(view.reshape(-1)), flat)


def ball(color: float) -> SceneDescription:
    builder = SceneBuilder((8, 8))
    builder.add(sphere(1.0, rings=16), diffuse(color))
    builder.description.world = background(1.0)
    return builder.description


@pytest.fixture
def maker() -> Iterator[PictureMaker]:
    result = PictureMaker()
    yield result
    result.close()
    result._thread.join(10.0)


def wait_for(condition: Callable[[], Any]) -> None:
    deadline = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def finished(maker: PictureMaker) -> Any:
    """The fine picture of the newest request."""
    wait_for(lambda: not maker.busy)
    assert not maker.error, maker.error
    picture = maker.shown
    assert picture is not None
    assert picture.session.wait(60.0)
    return picture


def middle(picture: Any) -> float:
    width, height = picture.size
    return float(picture.session.read("Combined", width // 2, height // 2, 1, 1)[0, 0, 0])


@pytest.mark.parametrize("pixel", [1, 2, 3, 16])
def test_coarse_pixels_cover_the_same_view(pixel: int) -> None:
    """Each coarse pixel shows what the fine ones in its place show."""
    view = replace(perspective(50, 31), border=(7, 5, 44, 30))
    fine, coarse = view.camera(1), view.camera(pixel)
    film = view.film(SceneDescription().film, pixel)
    assert film.width * pixel >= 50 > (film.width - 1) * pixel
    side = (fine.window[1] - fine.window[0]) / 50
    assert (coarse.window[1] - coarse.window[0]) / film.width == pytest.approx(side * pixel)
    assert (coarse.window[3] - coarse.window[2]) / film.height == pytest.approx(side * pixel)
    assert coarse.window[0] == fine.window[0]
    assert coarse.window[2] == fine.window[2]
    x0, y0, x1, y1 = film.crop
    assert x0 * pixel <= 7 < (x0 + 1) * pixel
    assert y0 * pixel <= 5 < (y0 + 1) * pixel
    assert (x1 - 1) * pixel < 44 <= x1 * pixel
    assert (y1 - 1) * pixel < 30 <= y1 * pixel


def test_a_picture_comes_coarse_and_then_fine(maker: PictureMaker) -> None:
    maker._rate = 1.0  # as of a machine on which only the coarsest picture comes in time
    sizes = []
    original = maker._render

    def spy(request: Request, state: Any, pixel: int, samples: int, first: bool) -> None:
        sizes.append((pixel, samples, first))
        original(request, state, pixel, samples, first)

    maker._render = spy  # type: ignore[method-assign]
    maker.ask(Request(perspective(64, 48), VALUES, ball(0.5)))
    picture = finished(maker)
    assert sizes == [(16, 1, True), (4, 1, False), (1, 3, False)]
    assert picture.size == (64, 48)
    # A convex white-lit ball sends back what it gets, times its colour.
    assert middle(picture) == pytest.approx(0.5, rel=1e-3)


def test_edits_and_moves(maker: PictureMaker) -> None:
    before = ball(0.5)
    view = perspective(40, 30)
    maker.ask(Request(view, VALUES, before))
    first = finished(maker)
    # The same again: the render goes on.
    maker.ask(Request(view, VALUES, copy.copy(before)))
    assert finished(maker) is first
    # Another colour.
    after = copy.copy(before)
    after.materials = copy.deepcopy(before.materials)
    after.materials[0].graph.nodes[0].inputs["Color"] = (0.25, 0.25, 0.25, 1.0)
    maker.ask(Request(view, VALUES, after))
    assert middle(finished(maker)) == pytest.approx(0.25, rel=1e-3)
    # Another view of it: from far off the ball is smaller than a pixel's neighbours.
    maker.ask(Request(perspective(40, 30, 60.0), VALUES, moved=True))
    far = finished(maker)
    corner = far.session.read("Combined", 0, 0, 1, 1)[0, 0, 0]
    assert corner == pytest.approx(1.0, rel=1e-3)
    # Other settings.
    maker.ask(Request(perspective(40, 30, 60.0), {**VALUES, "samples": 5}))
    assert finished(maker) is not far


def test_an_edit_that_was_overtaken_is_not_lost(maker: PictureMaker) -> None:
    """Many requests at once: what the last one shows has all of them in it."""
    view = perspective(320, 240)
    for step in range(10):
        maker.ask(Request(view, VALUES, ball(0.1 * step)))
        maker.ask(Request(view, VALUES, moved=True))
        time.sleep(0.002 * step)
    assert middle(finished(maker)) == pytest.approx(0.9, rel=1e-3)


def test_errors_are_told_and_forgotten(maker: PictureMaker) -> None:
    broken = ball(0.5)
    broken.meshes[0].positions[0, 0] = np.nan
    maker.ask(Request(perspective(20, 20), VALUES, broken))
    wait_for(lambda: maker.error)
    assert "sphere" in maker.error
    maker.ask(Request(perspective(20, 20), VALUES, ball(0.5)))
    wait_for(lambda: maker.shown is not None)
    finished(maker)


def closed_maker() -> weakref.ref[PictureMaker]:
    maker = PictureMaker()
    maker.ask(Request(perspective(200, 200), {**VALUES, "samples": 1 << 20}, ball(0.5)))
    wait_for(lambda: maker.shown is not None)
    maker.close()
    maker._thread.join(10.0)
    assert not maker._thread.is_alive()
    assert maker.shown is None
    return weakref.ref(maker)


def test_closing_frees_everything() -> None:
    reference = closed_maker()
    gc.collect()
    assert reference() is None
    assert not [t for t in threading.enumerate() if t.name == "vernier viewport"]
