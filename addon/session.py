"""A final render: describes, compiles, and streams the picture to Blender until it is done.

The core's threads never touch Python. This thread alone talks to Blender: it polls for cancel,
progress and tiles, and sleeps without the interpreter's lock in between.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import bpy
from engine_core.description import SceneDescription

from .checkpoint import Checkpoint
from .core import core
from .modelled import Modelled, describe
from .passes import DERIVED_PASSES, RenderPass, known_passes, wanted_passes
from .progress import ProgressLines, show_progress
from .record import RenderRecord, tell
from .settings import film_settings, render_settings
from .sync.depsgraph import SceneSync, SyncOptions

# Seconds between two looks at Blender's cancel flag.
POLL_SECONDS = 0.05
# Least seconds between two stats lines.
_STATS_SECONDS = 0.25
# Share of the time that may go into showing the picture as it grows.
_DISPLAY_SHARE = 0.05
# Above this share of changed pixels the whole picture is handed over at once.
_WHOLE_PICTURE = 0.25
# Messages that one render reports; the rest is counted.
_MAX_MESSAGES = 20
# Samples of material and light previews.
_PREVIEW_SAMPLES = 32


class CancelledError(Exception):
    """The user cancelled."""


class FinalRender:
    """Renders for one engine instance; keeps what did not change from frame to frame."""

    def __init__(self, engine: bpy.types.RenderEngine) -> None:
        self._engine = engine
        self._sync = SceneSync()

    def run(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Renders the depsgraph's view layer. Errors of the core are failures of the render."""
        from .engine import fail

        try:
            self._run(depsgraph)
        except CancelledError:
            pass
        except (ValueError, RuntimeError, MemoryError, OSError) as error:
            fail(self._engine, str(error) or type(error).__name__)

    def _run(self, depsgraph: bpy.types.Depsgraph) -> None:
        engine = self._engine
        scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
        called = time.perf_counter()
        engine.update_stats("", "Reading the scene")
        keep = scene.render.use_persistent_data
        if keep:
            self._sync.mark(depsgraph)
        else:
            self._sync = SceneSync()
        film = film_settings(scene)
        passes = wanted_passes(layer)
        keep_uv = any(item.name == "UV" for item in passes)
        options = SyncOptions(
            border=not engine.is_preview, keep_uv=keep_uv, camera=engine.camera_override, **film
        )
        description = self._sync.apply(depsgraph, options)
        messages = self._sync.report.messages
        if not keep:
            self._sync = SceneSync()  # the compiler is then the only one to hold the meshes
        if description.camera is None:
            raise ValueError(f'scene "{scene.name}" has no camera')
        values = render_settings(scene, layer)
        if engine.is_preview:
            values["samples"] = min(int(values["samples"]), _PREVIEW_SAMPLES)

        engine.update_stats("", "Building")
        described = time.perf_counter()
        threads = int(values["threads"])
        checkpoint = Checkpoint(scene, description, engine.is_preview)
        compiled = self._compile(description, threads, keep_uv, consume=not keep)
        built = time.perf_counter()
        session = self._session(compiled, values, [item.name for item in passes], checkpoint)
        messages = [*messages, *compiled.warnings, *session.notes]
        self._report(messages)
        x0, y0, x1, y1 = description.film.crop
        picture = _Picture(engine, layer.name, session, passes, x1 - x0, y1 - y0)
        self._lines = ProgressLines(scene, layer.name)
        self._checkpoint = checkpoint
        checkpoint.begin(session)
        try:
            progress = self._render(session, picture)
        finally:
            checkpoint.end()
        late = [note for note in session.notes if note not in messages]
        self._report(late)
        messages += late
        if not engine.is_preview:
            ended = time.perf_counter()
            times = (called, described, built, picture.first_shown, ended)
            tell(
                RenderRecord(
                    layer.name,
                    progress,
                    tuple(messages),
                    session.threads,
                    session.choice,
                    _modelled(compiled, passes),
                    *times,
                )
            )

    def _report(self, messages: list[str]) -> None:
        if self._engine.is_preview:
            return
        for message in messages[:_MAX_MESSAGES]:
            self._engine.report({"WARNING"}, message)
        if len(messages) > _MAX_MESSAGES:
            rest = len(messages) - _MAX_MESSAGES
            self._engine.report({"WARNING"}, f"and {rest} more messages of this kind")

    def _compile(
        self, description: SceneDescription, threads: int, keep_uv: bool, consume: bool
    ) -> Any:
        module = core()
        return self._apart(
            lambda stop: module.compile(description, threads, keep_uv, stop.is_set, consume)
        )

    def _session(
        self,
        compiled: Any,
        values: dict[str, Any],
        passes: list[str],
        checkpoint: Checkpoint,
    ) -> Any:
        module = core()
        if self._engine.is_preview:
            # Pictures of a material: others first learn the scene, or fill maps, for seconds.
            values["integrator"] = "PATH"
        return self._apart(
            lambda stop: module.Session(
                compiled, values, passes, resume=checkpoint.resume, digest=checkpoint.digest
            )
        )

    def _apart(self, make: Callable[[threading.Event], Any]) -> Any:
        """Makes something in a thread of its own, so that this one goes on asking for cancel.

        The event that `make` is handed is set when it is not wanted any more.
        """
        results: list[Any] = []
        errors: list[BaseException] = []
        stop = threading.Event()

        def work() -> None:
            try:
                results.append(make(stop))
            except BaseException as error:  # handed to the thread that waits
                errors.append(error)

        thread = threading.Thread(target=work, name="vernier prepare", daemon=True)
        thread.start()
        while thread.is_alive():
            thread.join(POLL_SECONDS)
            if self._engine.test_break():
                stop.set()  # the thread ends by itself; nobody waits for it
                raise CancelledError
        if errors:
            raise errors[0]
        return results[0]

    def _tell_choice(self, session: Any) -> bool:
        """Reports why Auto chose its method; False while it has not."""
        choice: str = session.choice
        if choice and not self._engine.is_preview:
            self._engine.report({"INFO"}, choice)
        return bool(choice)

    def _render(self, session: Any, picture: _Picture) -> Any:
        engine = self._engine
        session.start()
        show_progress(engine, session, with_error=False)
        cancelled = chosen = False
        next_stats = 0.0
        while not session.wait(POLL_SECONDS):
            if engine.test_break():
                cancelled = True
                session.cancel()
                break
            chosen = chosen or self._tell_choice(session)
            now = time.perf_counter()
            if now >= next_stats:
                self._lines.show(show_progress(engine, session, with_error=True))
                # As for the picture: what the error costs to compute spaces its updates.
                spent = time.perf_counter() - now
                next_stats = now + max(_STATS_SECONDS, spent / _DISPLAY_SHARE)
            picture.show_changes()
            self._checkpoint.save_when_due()
        while not session.wait(POLL_SECONDS):
            pass
        chosen = chosen or self._tell_choice(session)
        progress = show_progress(engine, session, with_error=not cancelled)
        self._lines.end(progress)
        picture.show_all(final=True)
        picture.describe(_metadata(session, progress))
        if session.error_message and not cancelled:
            raise ValueError(session.error_message)
        return progress


def _modelled(compiled: Any, passes: list[RenderPass]) -> Modelled:
    names = [item.name for item in passes]
    stored = [item for item in known_passes() if item.name not in DERIVED_PASSES]
    unused = sum(len(item.channels) for item in stored if item.name not in names)
    return describe(compiled.requirements, unused, compiled.width * compiled.height, names)


def _metadata(session: Any, progress: Any) -> dict[str, str]:
    """What a picture's file says of how it came about."""
    fields = {
        "integrator": session.integrator.lower(),
        "samples": f"{progress.samples:.6g}",
        "seconds": f"{progress.seconds:.2f}",
        "ended by": progress.ending,
        "error": f"{100.0 * progress.error:.3g} %",
        "confidence": "95 %",
    }
    return fields | ({"choice": session.choice} if session.choice else {})


class _Picture:
    """Blender's render result, and what of it is not shown yet."""

    def __init__(
        self,
        engine: bpy.types.RenderEngine,
        layer: str,
        session: Any,
        passes: list[RenderPass],
        width: int,
        height: int,
    ) -> None:
        self._engine = engine
        self._layer = layer
        self._session = session
        self._passes = passes
        self._size = (width, height)
        self._next = 0.0
        self.first_shown = 0.0  # by time.perf_counter
        for item in passes:
            if item.name != "Combined":
                engine.add_pass(item.blender_name, len(item.channels), item.channels, layer=layer)

    def show_changes(self) -> None:
        """Hands over what has changed, no more often than the display's share of time allows."""
        start = time.perf_counter()
        if start < self._next:
            return
        tiles = self._session.take_tiles()
        if not tiles:
            return
        width, height = self._size
        if sum(w * h for _, _, w, h in tiles) > _WHOLE_PICTURE * width * height:
            self._hand_over(0, 0, width, height, final=False)
        else:
            for x, y, w, h in tiles:
                self._hand_over(x, y, w, h, final=False)
        end = time.perf_counter()
        self._next = end + max((end - start) / _DISPLAY_SHARE, 2.0 * POLL_SECONDS)

    def show_all(self, final: bool) -> None:
        self._hand_over(0, 0, *self._size, final=final)

    def describe(self, fields: dict[str, str]) -> None:
        """Adds to the metadata of the picture's file."""
        result = self._engine.get_result()
        for field, value in fields.items() if result is not None else ():
            result.stamp_data_add_field(f"Vernier {self._layer} {field}", value)

    def _hand_over(self, x: int, y: int, width: int, height: int, final: bool) -> None:
        """Copies a rectangle of every pass; x and y count from the lower left of the border."""
        engine = self._engine
        result = engine.begin_result(x, y, width, height, layer=self._layer)
        if not result.layers:
            engine.end_result(result, cancel=True)
            return
        targets = {item.name: item for item in result.layers[0].passes}
        for item in self._passes:
            target = targets.get(item.blender_name)
            if target is not None:
                pixels = self._session.read(item.name, x, y, width, height)
                target.rect.foreach_set(pixels.reshape(-1))
        if not final:
            engine.update_result(result)
        engine.end_result(result)
        self.first_shown = self.first_shown or time.perf_counter()
