"""Vernier, a render engine for Blender: registration only.

The same folder is the extension that Blender installs and, with its parent on `sys.path`, the
module by which `bpy` gets the engine: `import addon; addon.register()`.
"""

from __future__ import annotations

_OLDEST = (4, 5, 0)


def register() -> None:
    """Makes the engine, its settings and its panels known to Blender."""
    import bpy

    if bpy.app.version < _OLDEST:
        oldest, here = (".".join(map(str, v[:2])) for v in (_OLDEST, bpy.app.version))
        raise RuntimeError(f"Vernier needs Blender {oldest} or later; this is {here}")
    from . import denoising, engine, panels, preset_menu, settings

    settings.register()
    engine.register()
    preset_menu.register()
    denoising.register()
    panels.register()


def unregister() -> None:
    """Takes them back, in reverse order."""
    from . import denoising, engine, panels, preset_menu, settings

    panels.unregister()
    denoising.unregister()
    preset_menu.unregister()
    engine.unregister()
    settings.unregister()
