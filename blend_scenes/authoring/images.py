"""Pictures painted with numpy and packed into the file. Row 0 of an array is the picture's foot."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def packed_image(name: str, pixels: Array, *, data: bool = False) -> bpy.types.Image:
    """Makes a packed 8-bit PNG of `pixels` (height, width, 3 or 4) in [0, 1].

    Colors are given as stored, that is sRGB-encoded; `data` marks plain numbers (normal maps).
    """
    height, width, channels = pixels.shape
    full = np.ones((height, width, 4))
    full[..., :channels] = np.clip(pixels, 0.0, 1.0)
    image = bpy.data.images.new(name, width, height, alpha=channels == 4, is_data=data)
    image.alpha_mode = "CHANNEL_PACKED" if channels == 4 else "NONE"
    image.pixels.foreach_set(full.astype(np.float32).ravel())
    image.pack()
    image.filepath_raw = f"//{name}.png"
    return image


def packed_radiance(name: str, pixels: Array) -> bpy.types.Image:
    """Makes a packed half-float OpenEXR picture of linear radiance (height, width, 3)."""
    height, width, _ = pixels.shape
    full = np.ones((height, width, 4), dtype=np.float32)
    full[..., :3] = pixels
    source = bpy.data.images.new(name, width, height, float_buffer=True, alpha=False)
    source.pixels.foreach_set(full.ravel())
    settings = bpy.context.scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "16"
    settings.color_mode, settings.exr_codec = "RGB", "ZIP"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.exr"
        source.save_render(str(path))
        bpy.data.images.remove(source)
        image = bpy.data.images.load(str(path))
        image.name = name
        image.pack()
    image.filepath_raw = f"//{name}.exr"
    settings.file_format = "PNG"
    return image


def value_noise(size: int, cells: int, seed: int, octaves: int = 4) -> Array:
    """Periodic value noise in [0, 1] of `size` x `size`, `cells` lumps across the first octave."""
    generator = np.random.default_rng(seed)
    total: Array = np.zeros((size, size))
    weight = 1.0
    for octave in range(octaves):
        n = cells * 2**octave
        lattice = generator.random((n, n))
        place = np.arange(size) * n / size
        low = place.astype(int)
        t = place - low
        t = t * t * (3.0 - 2.0 * t)
        next_ = (low + 1) % n
        rows = lattice[low] * (1 - t)[:, None] + lattice[next_] * t[:, None]
        total += weight * (rows[:, low] * (1 - t) + rows[:, next_] * t)
        weight *= 0.5
    low_end, high_end = np.min(total), np.max(total)
    return np.asarray((total - low_end) / (high_end - low_end))


def normals_from_height(height: Array, strength: float) -> Array:
    """Tangent-space normal map of a periodic height picture; `strength` is slope per pixel step."""
    slope_x = strength * (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / 2
    slope_y = strength * (np.roll(height, -1, 0) - np.roll(height, 1, 0)) / 2
    normal = np.stack([-slope_x, -slope_y, np.ones_like(height)], axis=-1)
    return 0.5 + 0.5 * normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def parquet(size: int, seed: int) -> tuple[Array, Array]:
    """Staggered planks: sRGB colors and a height picture; both repeat."""
    rows, offset_generator = 8, np.random.default_rng(seed)
    y, x = np.mgrid[0:size, 0:size] / size
    row = (y * rows).astype(int)
    shift = offset_generator.random(rows)[row]
    along = (x + shift) % 1.0 * 2.0
    plank = row * 2 + along.astype(int)
    tone = offset_generator.random(rows * 2)[plank]
    grain = value_noise(size, 4, seed + 1, 3)
    streaks = np.repeat(np.random.default_rng(seed + 2).random(size)[:, None], size, axis=1)
    fibre = 0.55 * streaks + 0.45 * grain
    across = (y * rows) % 1.0
    gap = (np.minimum(across, 1 - across) < 0.03) | (np.minimum(along % 1, 1 - along % 1) < 0.005)
    shade = (0.72 + 0.28 * tone + 0.16 * (fibre - 0.5)) * np.where(gap, 0.35, 1.0)
    color = np.array([0.68, 0.48, 0.31]) * shade[..., None]
    return color, np.where(gap, 0.0, 0.8 + 0.2 * fibre)


def leaf(size: int) -> Array:
    """A leaf from the left edge to the right, RGBA in sRGB; alpha is 0 or 1."""
    y, x = np.mgrid[0:size, 0:size] / (size - 1)
    half = 0.46 * np.sin(np.pi * np.clip(x, 0, 1) ** 0.8) ** 0.9
    offset = np.abs(y - 0.5)
    vein = np.abs((offset * 2.2 - x * 1.6) * 9 % 1.0 - 0.5) < 0.07
    rib = offset < 0.012
    color = np.empty((size, size, 4))
    fade = (0.75 + 0.25 * x)[..., None]
    color[..., :3] = np.array([0.22, 0.46, 0.16]) * fade
    color[vein, :3] = [0.33, 0.56, 0.24]
    color[rib, :3] = [0.5, 0.66, 0.33]
    color[..., 3] = (offset < half) | (offset < 0.012)
    return color


def rug(size: int) -> Array:
    """A woven rug with a border and nested lozenges, sRGB."""
    y, x = np.mgrid[0:size, 0:size] / size
    palette = np.array([[0.58, 0.13, 0.11], [0.88, 0.8, 0.64], [0.13, 0.2, 0.32], [0.8, 0.55, 0.2]])
    lozenge = (np.abs((x * 3) % 1 - 0.5) + np.abs((y * 2) % 1 - 0.5)) * 8
    index = lozenge.astype(int) % 4
    edge = np.minimum(np.minimum(x, 1 - x) * 1.5, np.minimum(y, 1 - y))
    index = np.where(edge < 0.09, ((x * 24).astype(int) + (y * 16).astype(int)) % 2 * 2, index)
    index = np.where((edge < 0.035) | (np.abs(edge - 0.09) < 0.008), 1, index)
    thread = 0.9 + 0.1 * np.sin(x * size * np.pi / 2) * np.sin(y * size * np.pi / 2)
    return np.asarray(palette[index] * thread[..., None])


def landscape(width: int, height: int) -> Array:
    """A poster: hills under a low sun, sRGB."""
    y, x = np.mgrid[0:height, 0:width]
    x, y = x / width, y / height
    top, low = np.array([0.16, 0.32, 0.46]), np.array([0.97, 0.78, 0.52])
    color = low + (top - low) * np.clip((y - 0.3) / 0.7, 0, 1)[..., None]
    color[np.hypot((x - 0.66) * width / height, y - 0.56) < 0.1] = [0.98, 0.93, 0.78]
    hills = [
        (0.5, 0.07, 5.0, [0.62, 0.55, 0.53]),
        (0.4, 0.08, 7.0, [0.42, 0.4, 0.46]),
        (0.27, 0.06, 9.0, [0.2, 0.26, 0.36]),
        (0.13, 0.05, 6.0, [0.08, 0.13, 0.2]),
    ]
    for phase, (level, swell, frequency, tint) in enumerate(hills):
        line = level + swell * np.sin(frequency * x + 2 * phase) + 0.02 * np.sin(31 * x + phase)
        color[y < line] = tint
    return np.asarray(color**0.75)
