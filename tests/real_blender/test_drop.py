"""The zip dropped onto Blender's window.

A virtual screen has nothing to drag from. So the file arrives as from Blender's own handling of
drops, which calls the operator below with its path; the dialog that this opens is confirmed by key.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .conftest import PICTURES
from .machine import Machine
from .session import BlenderSession


def test_a_dropped_file_is_installed(
    machine: Machine, extension: Path, empty_profile: Path
) -> None:
    PICTURES.mkdir(parents=True, exist_ok=True)
    session = BlenderSession(machine, empty_profile, PICTURES)
    try:
        session.run("bpy.context.preferences.view.show_splash = False")
        session.key("Escape")
        assert session.run('result = hasattr(bpy.types.Scene, "vernier")') is False
        session.move(500, 400)

        def calm() -> bool:
            shots = [session.picture("drop_before") for _ in range(2)]
            return bool(np.array_equal(*shots))

        session.wait_until(calm, 60.0, "a window without the splash, which stays as it is")
        before = session.picture("drop_before")
        session.run(
            f"""
window = bpy.context.window_manager.windows[0]
with bpy.context.temp_override(window=window):
    bpy.ops.extensions.package_install_files("INVOKE_DEFAULT", url={machine.path(extension)!r})
"""
        )
        session.wait_until(
            lambda: (np.abs(session.picture("drop_dialog") - before) > 0.02).mean() > 0.02,
            60.0,
            "the dialog",
        )
        session.key("Return")
        session.wait_until(
            lambda: session.run('result = hasattr(bpy.types.Scene, "vernier")'),
            300.0,
            "the extension",
        )
        session.run('bpy.context.scene.render.engine = "VERNIER"')
        session.picture("drop_installed")
    finally:
        session.close()
