"""Renders what a 3D view shows, in a thread of its own that the interface never waits for."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field
from typing import Any

from engine_core.description import SceneDescription

from ..core import core
from .view import View

Values = dict[str, bool | int | float | str]

# Seconds that the first, coarse picture of a new view may take.
_FIRST_SECONDS = 0.04
# Pixels a second that one sample each is reckoned to take before anything has been measured.
_GUESSED_RATE = 5e5
# Coarsest pixels, in the region's.
_MAX_PIXEL = 16
# From one picture to the next finer one.
_PIXEL_STEP = 4
# Seconds for which a moved view must stand still before it is rendered finely.
_REST_SECONDS = 0.12
# Seconds between two looks at a render in progress.
_POLL_SECONDS = 0.01


@dataclass
class Request:
    """What is to be shown. `description` None: the scene is as it was."""

    view: View
    values: Values
    description: SceneDescription | None = None
    moved: bool = False  # only the view changed: more changes of it will follow


@dataclass(frozen=True)
class Picture:
    """A render of a view, in progress or done; `pixel` is the size of its pixels."""

    session: Any
    view: View
    pixel: int
    crop: tuple[int, int, int, int]  # in its own pixels

    @property
    def size(self) -> tuple[int, int]:
        x0, y0, x1, y1 = self.crop
        return x1 - x0, y1 - y0


@dataclass
class _State:
    """What the thread has: the compiled scene, and what it was asked for last."""

    scene: Any = None
    description: SceneDescription | None = None
    view: View | None = None
    values: Values = field(default_factory=dict)
    stale: bool = True  # what is shown is not this


class PictureMaker:
    """Makes pictures of one 3D view: of the newest request, coarse first, then fine."""

    def __init__(self) -> None:
        self._condition = threading.Condition()
        self._request: Request | None = None
        self._closed = False
        self._stop_compiling = threading.Event()
        self._rate = _GUESSED_RATE
        self._thread = threading.Thread(target=self._work, name="vernier viewport", daemon=True)
        self._thread.start()
        # For the interface's thread to read.
        self.shown: Picture | None = None  # the newest that covers its region
        self.error = ""
        self.busy = False  # a request is not yet shown finely

    def ask(self, request: Request) -> None:
        """Replaces what is being made; returns at once."""
        with self._condition:
            waiting = self._request
            if request.description is None and waiting is not None:
                request.description = waiting.description
                request.moved = request.moved and waiting.description is None
            if request.description is not None:
                self._stop_compiling.set()
            self._request = request
            self.busy = True
            self._condition.notify()

    def close(self) -> None:
        """Ends the thread and the render, soon."""
        with self._condition:
            self._closed = True
            self._stop_compiling.set()
            self._condition.notify()

    def _work(self) -> None:
        state = _State()
        while (request := self._next()) is not None:
            try:
                self._serve(request, state)
                self.error = ""
            except Exception as error:  # of the core, about the scene; nobody else would tell it
                if not self._is_superseded():
                    self.error = str(error) or type(error).__name__
            self.busy = self._is_superseded()
        self.shown = None

    def _next(self) -> Request | None:
        with self._condition:
            while self._request is None and not self._closed:
                self._condition.wait()
            request, self._request = self._request, None
            self._stop_compiling.clear()
            return None if self._closed else request

    def _is_superseded(self) -> bool:
        return self._request is not None or self._closed

    def _serve(self, request: Request, state: _State) -> None:
        state.stale |= request.values != state.values or request.view != state.view
        if request.description is not None:
            state.scene = self._compile(request, state)
            # After an edit of what the picture does not show, its render goes on.
            known = state.description
            state.stale |= known is None or known.film != request.description.film
            state.stale |= state.scene.compiled["changed"]
            state.description = request.description
        state.values, state.view = request.values, request.view
        if state.description is None or not state.stale:
            return
        finest = int(request.values["pixel"])
        sizes = self._pixel_sizes(request.view, finest)
        for pixel in sizes:
            if pixel != sizes[0] and self._is_superseded():
                return
            samples = int(request.values["samples"]) if pixel == finest else 1
            self._render(request, state, pixel, samples, first=pixel == sizes[0])
            if pixel > finest and request.moved and not self._rests():
                return
        state.stale = self._is_superseded()

    def _compile(self, request: Request, state: _State) -> Any:
        description = request.description
        assert description is not None
        description.camera = request.view.camera()
        threads = int(request.values.get("threads", 0))
        return core().compile(
            description,
            threads,
            cancelled=self._stop_compiling.is_set,
            interactive=True,
            previous=state.scene,
        )

    def _pixel_sizes(self, view: View, finest: int) -> list[int]:
        """Sizes of pixels, coarse to fine; the first are large enough to be there in time."""
        x0, y0, x1, y1 = view.crop
        coarse = finest
        while (x1 - x0) * (y1 - y0) / coarse**2 > _FIRST_SECONDS * self._rate:
            if coarse >= _MAX_PIXEL:
                break
            coarse *= 2
        sizes = [coarse]
        while sizes[-1] > finest:
            sizes.append(max(sizes[-1] // _PIXEL_STEP, finest))
        return sizes

    def _render(
        self, request: Request, state: _State, pixel: int, samples: int, first: bool
    ) -> None:
        """Renders until the picture is whole, and shows it; a fine one then goes on by itself.

        Only the `first` picture of a request is made to its end when another request comes: a view
        that moves on and on must still be seen to move.
        """
        assert state.description is not None
        film = request.view.film(state.description.film, pixel)
        scene = core().with_view(state.scene, request.view.camera(pixel), film)
        values = {**request.values, "samples": samples}
        del values["pixel"]
        session = core().Session(scene, values, ["Combined"], give_way=True)
        picture = Picture(session, request.view, pixel, film.crop)
        start = time.perf_counter()
        session.start()
        while not session.wait(_POLL_SECONDS) and session.poll().samples < 1.0:
            if self._is_superseded() and self.shown is not None and not first:
                session.cancel()
                return
        width, height = picture.size
        spent = max(time.perf_counter() - start, 1e-4)
        self._rate = max(width * height * session.poll().samples / spent, 1.0)
        if session.error_message:
            raise RuntimeError(session.error_message)
        before, self.shown = self.shown, picture
        if before is not None:
            before.session.cancel()

    def _rests(self) -> bool:
        """Waits for the view to rest; False when a new request comes first."""
        with self._condition:
            self._condition.wait_for(self._is_superseded, _REST_SECONDS)
            return not self._is_superseded()
