"""Vernier, a render engine for Blender: registration only.

The same folder is the extension that Blender installs and, with its parent on `sys.path`, the
module by which `bpy` gets the engine: `import addon; addon.register()`.
"""

from __future__ import annotations


def register() -> None:
    """Makes the engine, its settings and its panels known to Blender."""
    from . import engine, panels, settings

    settings.register()
    engine.register()
    panels.register()


def unregister() -> None:
    """Takes them back, in reverse order."""
    from . import engine, panels, settings

    panels.unregister()
    engine.unregister()
    settings.unregister()
