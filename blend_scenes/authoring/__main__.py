"""`python -m blend_scenes.authoring [NAME ...]` rebuilds the scenes."""

from .make import run

run()
