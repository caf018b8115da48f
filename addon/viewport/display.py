"""Draws a picture into a region."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from .pictures import Picture


class Display:
    """The newest pixels of a picture as a texture of the graphics card."""

    def __init__(self) -> None:
        self._picture: Picture | None = None
        self._texture: Any = None

    def draw(
        self, picture: Picture, fresh: bool, engine: bpy.types.RenderEngine, scene: bpy.types.Scene
    ) -> None:
        """Draws `picture`; reads its pixels again when it is another one or `fresh`."""
        import gpu
        from gpu_extras.presets import draw_texture_2d

        if fresh or picture is not self._picture:
            self._texture = _texture(picture)
            self._picture = picture
        x0, y0, _, _ = picture.crop
        width, height = picture.size
        pixel = picture.pixel
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        place = (x0 * pixel, y0 * pixel)
        draw_texture_2d(self._texture, place, width * pixel, height * pixel)
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")


def _texture(picture: Picture) -> Any:
    import gpu

    width, height = picture.size
    pixels = picture.session.read("Combined", 0, 0, width, height)
    flat = np.ascontiguousarray(pixels, np.float32).reshape(-1)
    data = gpu.types.Buffer("FLOAT", flat.size, flat)
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=data)
