"""Runs inside Blender: executes what the test writes into a folder, and answers.

A request is a file `N.request` of Python code; the code runs in Blender's main thread with `bpy`
and `context()` at hand and sets `result` to what JSON can hold. The answer is `N.answer`: `result`,
or a traceback.
"""

import json
import os
import sys
import traceback
from pathlib import Path

import bpy

FOLDER = Path(sys.argv[sys.argv.index("--") + 1])
PERIOD = 0.02  # seconds between two looks
STORE = {}


def window():
    return bpy.context.window_manager.windows[0]


def area(kind):
    """The largest area of a kind."""
    found = [item for item in window().screen.areas if item.type == kind]
    return max(found, key=lambda item: item.width * item.height)


def context(kind="VIEW_3D"):
    """An override of the context: the window's largest area of a kind."""
    place = area(kind)
    region = next(item for item in place.regions if item.type == "WINDOW")
    return bpy.context.temp_override(window=window(), area=place, region=region)


def answer(request):
    names = {"bpy": bpy, "context": context, "area": area, "window": window, "store": STORE}
    try:
        names["result"] = None
        exec(compile(request.read_text(), request.name, "exec"), names)
        text = json.dumps({"result": names["result"]})
    except Exception:
        text = json.dumps({"error": traceback.format_exc()})
    target = request.with_suffix(".answer")
    part = request.with_suffix(".part")
    part.write_text(text)
    request.unlink()
    os.rename(part, target)


def look():
    for request in sorted(FOLDER.glob("*.request"), key=lambda path: int(path.stem)):
        answer(request)
    return PERIOD


bpy.app.timers.register(look, persistent=True)
