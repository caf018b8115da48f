"""Images: bytes, floats, colour spaces, alpha, what is missing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from engine_core.description import Image

from addon.sync.images import read_image, sequence_frame
from addon.sync.report import Report

PIXELS = np.array([[(0, 51, 102, 255), (153, 204, 255, 255)]], np.uint8)  # one row of two


def _new(name: str, pixels: np.ndarray = PIXELS, is_float: bool = False) -> Any:
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=is_float)
    values = pixels if is_float else pixels / 255.0
    image.pixels.foreach_set(np.ascontiguousarray(values, np.float32).reshape(-1))
    return image


def _read(image: Any) -> tuple[Image, list[str]]:
    report = Report()
    return read_image(image, 0, report), report.messages


def _saved(image: Any, path: Path, kind: str) -> Any:
    image.filepath_raw, image.file_format = str(path), kind
    image.save()
    return bpy.data.images.load(str(path))


def test_bytes_stay_bytes(empty_scene: Any) -> None:
    result, messages = _read(_new("Bytes"))
    assert (result.encoding, result.alpha, messages) == ("srgb", "STRAIGHT", [])
    np.testing.assert_array_equal(result.pixels, PIXELS[:, :, :3])


def test_alpha_is_kept_where_there_is_some(empty_scene: Any) -> None:
    pixels = PIXELS.copy()
    pixels[0, 1, 3] = 128
    np.testing.assert_array_equal(_read(_new("Alpha", pixels))[0].pixels, pixels)


def test_every_byte_survives(empty_scene: Any) -> None:
    ramp = np.zeros((1, 256, 4), np.uint8)
    ramp[0, :, 0], ramp[:, :, 3] = np.arange(256), 255
    result, _ = _read(_new("Ramp", ramp))
    np.testing.assert_array_equal(result.pixels, ramp[:, :, :3])


def test_files_and_packed_files(empty_scene: Any, tmp_path: Path) -> None:
    image = _saved(_new("Source"), tmp_path / "picture.png", "PNG")
    np.testing.assert_array_equal(_read(image)[0].pixels, PIXELS[:, :, :3])
    image.pack()
    (tmp_path / "picture.png").unlink()
    image.buffers_free()
    np.testing.assert_array_equal(_read(image)[0].pixels, PIXELS[:, :, :3])


def test_rows_go_up(empty_scene: Any) -> None:
    pixels = np.zeros((2, 1, 4), np.uint8)
    pixels[0, 0], pixels[1, 0] = (10, 0, 0, 255), (20, 0, 0, 255)
    image = _new("Rows", pixels)
    assert _read(image)[0].pixels[:, 0, 0].tolist() == [10, 20]  # type: ignore[index]


@pytest.mark.parametrize("space", ["Non-Color", "Linear Rec.709"])
def test_linear_bytes(empty_scene: Any, space: str) -> None:
    image = _new("Data")
    image.colorspace_settings.name = space
    result, messages = _read(image)
    assert (result.encoding, messages) == ("linear", [])
    assert result.pixels is not None
    assert result.pixels.dtype == np.uint8
    assert result.alpha == ("CHANNEL_PACKED" if space == "Non-Color" else "STRAIGHT")


def test_other_spaces_become_linear_floats(empty_scene: Any, tmp_path: Path) -> None:
    image = _saved(_new("Wide"), tmp_path / "wide.png", "PNG")
    image.colorspace_settings.name = "Linear Rec.2020"
    result, messages = _read(image)
    assert (result.encoding, messages) == ("linear", [])
    assert result.pixels is not None
    assert result.pixels.dtype == np.float32
    # ITU-R BT.2087-0: from BT.2020's primaries to BT.709's.
    matrix = np.array(
        [(1.6605, -0.5876, -0.0728), (-0.1246, 1.1329, -0.0083), (-0.0182, -0.1006, 1.1187)]
    )
    expected = (PIXELS[:, :, :3] / 255.0) @ matrix.T
    np.testing.assert_allclose(result.pixels, expected, atol=2e-3)


def test_floats(empty_scene: Any, tmp_path: Path) -> None:
    oiio = pytest.importorskip("OpenImageIO")
    pixels = np.array([[(0.5, 1e9, -1.0, 1.0), (0.25, 2.0, 0.0, 1.0)]], np.float32)
    path = str(tmp_path / "picture.exr")
    output = oiio.ImageOutput.create(path)
    output.open(path, oiio.ImageSpec(2, 1, 4, oiio.FLOAT))
    output.write_image(pixels)
    output.close()
    result, messages = _read(bpy.data.images.load(path))
    assert (result.encoding, result.alpha, messages) == ("linear", "PREMUL", [])
    np.testing.assert_allclose(result.pixels, pixels[:, :, :3], rtol=1e-3)  # type: ignore[arg-type]


def test_floats_that_are_not_finite_are_named(empty_scene: Any) -> None:
    pixels = np.array([[(np.inf, np.nan, 1.0, 1.0)]], np.float32)
    result, messages = _read(_new("Bad", pixels, True))
    assert result.pixels[0, 0].tolist() == [0.0, 0.0, 1.0]  # type: ignore[index]
    assert messages == ['image "Bad": holds pixels that are not finite; they are read as 0']


@pytest.mark.parametrize("content", [None, b"", b"\x89PNG\r\n\x1a\n", b"no image at all"])
def test_missing_empty_and_damaged_files(
    broken_image: Any, tmp_path: Path, content: bytes | None
) -> None:
    image = broken_image(content)
    path = tmp_path / "picture.png"
    result, messages = _read(image)
    assert result.pixels is None
    assert messages == [f'image "picture.png": cannot be read ({path}); it is drawn magenta']


def test_alpha_modes(empty_scene: Any) -> None:
    image = _new("Packed")
    for mode in ("CHANNEL_PACKED", "NONE"):
        image.alpha_mode = mode
        assert _read(image)[0].alpha == mode


def test_generated(empty_scene: Any) -> None:
    image = bpy.data.images.new("Grid", 8, 4)
    image.generated_type = "UV_GRID"
    pixels = _read(image)[0].pixels
    assert pixels is not None
    assert pixels.shape == (4, 8, 3)


def test_tiles_are_named(empty_scene: Any) -> None:
    image = bpy.data.images.new("Tiles", 2, 2, tiled=True)
    assert any("tiles (UDIM) are not supported" in message for message in _read(image)[1])


def test_sequences(empty_scene: Any, tmp_path: Path) -> None:
    pytest.importorskip("OpenImageIO")
    for number in (1, 2, 3):
        pixels = np.full((1, 1, 4), 255, np.uint8)
        pixels[0, 0, 0] = 10 * number
        _saved(_new(f"Frame {number}", pixels), tmp_path / f"wave_{number:03d}.png", "PNG")
    image = bpy.data.images.load(str(tmp_path / "wave_001.png"), check_existing=True)
    image.source = "SEQUENCE"
    node = bpy.data.materials.new("M")
    if bpy.app.version < (5, 0, 0):
        node.use_nodes = True
    user = node.node_tree.nodes.new("ShaderNodeTexImage").image_user
    user.frame_start, user.frame_duration, user.frame_offset = 11, 3, 0
    frames = [sequence_frame(image, user, frame) for frame in (1, 11, 12, 13, 99)]
    assert frames == [1, 1, 2, 3, 3]
    user.use_cyclic = True
    assert [sequence_frame(image, user, frame) for frame in (14, 15)] == [1, 2]
    report = Report()
    pixels_2 = read_image(image, 2, report).pixels
    assert pixels_2 is not None
    assert (pixels_2[0, 0, 0], report.messages) == (20, [])


@pytest.mark.parametrize(
    ("space", "red"),
    [("sRGB", ((0.5 + 0.055) / 1.055) ** 2.4), ("Non-Color", 0.5), ("Linear Rec.709", 0.5)],
)
def test_deep_sequences_are_in_their_color_space(
    empty_scene: Any, tmp_path: Path, space: str, red: float
) -> None:
    oiio = pytest.importorskip("OpenImageIO")
    path = tmp_path / "deep_001.png"
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), oiio.ImageSpec(1, 1, 3, "uint16"))
    output.write_image(np.full((1, 1, 3), 0.5, np.float32))
    output.close()
    image = bpy.data.images.load(str(path))
    image.source = "SEQUENCE"
    image.colorspace_settings.name = space
    report = Report()
    result = read_image(image, 1, report)
    assert result.pixels is not None
    assert (result.encoding, report.messages) == ("linear", [])
    assert float(result.pixels[0, 0, 0]) == pytest.approx(red, abs=1e-4)


def test_an_image_is_exported_once(make: Any, export: Any) -> None:
    image = _new("Shared")
    mesh = make.quad("Quad", uv=True)
    for name in ("A", "B"):
        material = make.material(name)
        nodes, links = material.node_tree.nodes, material.node_tree.links
        texture = nodes.new("ShaderNodeTexImage")
        texture.image = image
        surface, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
        links.new(texture.outputs[0], surface.inputs["Color"])
        links.new(surface.outputs[0], output.inputs["Surface"])
        mesh.materials.append(material)
    make.object("Quad", mesh)
    description = export()[0]
    assert [item.name for item in description.images] == ["Shared"]
    textures = [n for m in description.materials for n in m.graph.nodes if "TexImage" in n.kind]
    assert [node.params["image"] for node in textures] == [0, 0]
