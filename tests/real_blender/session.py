"""A Blender with a window on a virtual screen, driven by Python code and by keys and clicks."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TextIO

import numpy as np
import OpenImageIO
from numpy.typing import NDArray

from .machine import Machine

SCREEN = (1280, 800)
DRIVER = Path(__file__).with_name("driver.py")


class BlenderSession:
    """One window. Pictures are float arrays (height, width, 3) in [0, 1], top row first."""

    def __init__(self, machine: Machine, profile: Path, pictures: Path) -> None:
        self._machine = machine
        self._pictures = pictures
        self._display = 0
        self._folder = Path(tempfile.mkdtemp(prefix="session-", dir=machine.outside))
        self._folder.chmod(0o755)
        (self._folder / "driver.py").write_text(DRIVER.read_text())
        self._count = 0
        self._log = open(self._folder / "blender.log", "w")  # noqa: SIM115 - closed in close()
        screen = f"{SCREEN[0]}x{SCREEN[1]}x24"
        number = self._folder / "display"
        with open(number, "w") as file:
            # The server writes the number of its display, the first free one, to its output.
            options = ["-displayfd", "1", "-screen", "0", screen, "+extension", "GLX", "-nocursor"]
            self._server = self._start(["Xvfb", *options], file)
        deadline = time.monotonic() + 30.0
        while not number.read_text().endswith("\n"):
            if time.monotonic() > deadline:
                raise RuntimeError(f"the virtual screen does not start\n{self.log()}")
            time.sleep(0.1)
        self._display = int(number.read_text())
        self._profile = profile
        self.blender = self._start(
            [
                machine.blender,
                "--gpu-backend",
                "opengl",
                "-noaudio",
                "--window-geometry",
                "0",
                "0",
                str(SCREEN[0]),
                str(SCREEN[1]),
                "--python",
                machine.path(self._folder / "driver.py"),
                "--",
                machine.path(self._folder),
            ]
        )
        self.run("result = bpy.app.version_string", timeout=120.0)

    def _variables(self) -> dict[str, str]:
        variables = {"DISPLAY": f":{self._display}", "LIBGL_ALWAYS_SOFTWARE": "1"}
        if hasattr(self, "_profile"):
            variables["BLENDER_USER_RESOURCES"] = self._machine.path(self._profile)
        return variables

    def _start(self, arguments: list[str], output: TextIO | None = None) -> subprocess.Popen[str]:
        return subprocess.Popen(
            self._machine.command(arguments, self._variables()),
            stdout=output or self._log,
            stderr=self._log,
            text=True,
        )

    def _tool(self, arguments: list[str]) -> subprocess.CompletedProcess[str]:
        return self._machine.run(arguments, self._variables(), timeout=300.0)

    # Driving.

    def run(self, code: str, timeout: float = 300.0) -> Any:
        """Runs code in Blender's main thread (driver.py says what it has) and returns `result`."""
        self._count += 1
        request = self._folder / f"{self._count}.request"
        part = request.with_suffix(".part")
        part.write_text(code)
        os.rename(part, request)
        target = request.with_suffix(".answer")
        self.wait_until(target.exists, timeout, f"an answer to:\n{code}")
        answer = json.loads(target.read_text())
        if "error" in answer:
            raise AssertionError(f"in Blender:\n{answer['error']}")
        return answer["result"]

    def wait_until(self, condition: Callable[[], Any], timeout: float, what: str) -> float:
        """Waits for a condition and returns the seconds it took; fails after `timeout`."""
        start = time.monotonic()
        while not condition():
            assert self.blender.poll() is None, f"Blender ended; waiting for {what}\n{self.log()}"
            assert time.monotonic() - start < timeout, f"not in {timeout} s: {what}\n{self.log()}"
            time.sleep(0.02)
        return time.monotonic() - start

    def key(self, name: str) -> None:
        """Presses a key, named as X names it, perhaps with modifiers ("ctrl+F12")."""
        # By its number: by its name F12 is found on the level that alt selects.
        self._tool(["xdotool", "key", name.replace("F12", "96")])

    def move(self, x: int, y: int) -> None:
        """Moves the pointer; y counts from the top."""
        self._tool(["xdotool", "mousemove", str(x), str(y)])

    def scroll(self, x: int, y: int, clicks: int) -> None:
        """Turns the wheel towards the user."""
        self._tool(["xdotool", "mousemove", str(x), str(y), "click", "--repeat", str(clicks), "5"])

    def drag(self, button: int, points: list[tuple[int, int]], pause: float = 0.05) -> None:
        """Presses a button at the first point, goes through the others, and lets go."""
        words = ["mousemove", *map(str, points[0]), "mousedown", str(button)]
        for point in points[1:]:
            words += ["sleep", str(pause), "mousemove", *map(str, point)]
        self._tool(["xdotool", *words, "sleep", str(pause), "mouseup", str(button)])

    def picture(self, name: str) -> NDArray[np.float32]:
        """Takes a screenshot and keeps it as `name`.png among the pictures."""
        path = self._folder / f"{name}.png"
        done = self._tool(["import", "-window", "root", self._machine.path(path)])
        assert done.returncode == 0, done.stderr
        buffer = OpenImageIO.ImageBuf(str(path))
        buffer.write(str(self._pictures / f"{name}.png"))
        pixels = buffer.get_pixels(OpenImageIO.FLOAT)
        return np.ascontiguousarray(pixels[:, :, :3])

    def area(self, kind: str) -> tuple[slice, slice]:
        """Where the main region of the largest area of a kind lies in pictures."""
        box = self.run(
            f"""
place = area({kind!r})
region = next(item for item in place.regions if item.type == "WINDOW")
result = [region.x, region.y, region.width, region.height, window().height]
"""
        )
        x, y, width, height, total = box
        return slice(total - y - height, total - y), slice(x, x + width)

    def inside(self, name: str) -> str:
        """A file of this session as Blender sees it."""
        return self._machine.path(self._folder / name)

    def outside(self, name: str) -> Path:
        """The same file as seen from here."""
        return self._folder / name

    def log(self) -> str:
        self._log.flush()
        return (self._folder / "blender.log").read_text()[-4000:]

    def alive(self) -> bool:
        return self.blender.poll() is None

    def close(self) -> None:
        """Ends Blender, kindly at first, and the screen."""
        try:
            self.run("bpy.app.timers.register(lambda: bpy.ops.wm.quit_blender() and None)")
            self.blender.wait(20.0)
        except (AssertionError, subprocess.TimeoutExpired):
            pass
        for process in (self.blender, self._server):
            # The sandbox's processes end with what started them, at no milder signal.
            process.kill()
            process.wait()
        self._log.close()
