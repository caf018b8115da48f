"""A real Blender with the extension installed from its zip into an empty profile.

The tests skip where there is no Blender (BLENDER unset and no sandbox) or no zip.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from .machine import ROOT, Machine
from .session import BlenderSession

# Screenshots are kept here to be looked at.
PICTURES = ROOT / "out" / "real_blender"


@pytest.fixture(scope="session")
def machine() -> Iterator[Machine]:
    found = Machine.find()
    if isinstance(found, str):
        pytest.skip(found)
    yield found
    shutil.rmtree(found.outside, ignore_errors=True)


@pytest.fixture(scope="session")
def extension(machine: Machine) -> Path:
    """The zip, where Blender sees it: VERNIER_EXTENSION, or what scripts/build_extension made."""
    version = tomllib.loads((ROOT / "addon" / "blender_manifest.toml").read_text())["version"]
    built = ROOT / "dist" / f"vernier-{version}.zip"
    path = Path(os.environ.get("VERNIER_EXTENSION", built))
    if not path.is_file():
        pytest.skip(f"there is no {path}: build it by scripts/build_extension")
    return Path(shutil.copy(path, machine.outside))


@pytest.fixture
def empty_profile(machine: Machine) -> Path:
    """A folder for the user's files of a Blender that has never run."""
    return Path(tempfile.mkdtemp(prefix="profile-", dir=machine.outside))


def install(machine: Machine, extension: Path, profile: Path) -> str:
    """Installs and enables a zip; returns what Blender printed."""
    command = ["--command", "extension", "install-file", "-r", "user_default", "-e"]
    done = machine.run_blender([*command, machine.path(extension)], profile)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.fixture(scope="session")
def profile(machine: Machine, extension: Path) -> Path:
    """A profile with the extension installed."""
    folder = Path(tempfile.mkdtemp(prefix="profile-", dir=machine.outside))
    install(machine, extension, folder)
    return folder


@pytest.fixture(scope="session")
def window(machine: Machine, profile: Path) -> Iterator[BlenderSession]:
    """Blender in a window, for all tests: starting it takes seconds."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    session = BlenderSession(machine, profile, PICTURES)
    yield session
    session.close()


@pytest.fixture
def blender(window: BlenderSession) -> BlenderSession:
    """The window with the default scene, rendered by Vernier, its cube red."""
    assert window.alive(), window.log()
    window.run(
        """
bpy.context.preferences.view.show_splash = False
bpy.context.preferences.view.render_display_type = "AREA"
bpy.ops.wm.read_homefile(use_factory_startup=True)
"""
    )
    window.run(
        """
scene = bpy.context.scene
scene.render.engine = "VERNIER"
scene.render.resolution_x, scene.render.resolution_y = 640, 360
scene.vernier.samples = 16
shader = bpy.data.objects["Cube"].active_material.node_tree.nodes["Principled BSDF"]
shader.inputs["Base Color"].default_value = (0.8, 0.02, 0.02, 1.0)
"""
    )
    window.key("Escape")
    return window


def redness(pixels: np.ndarray) -> float:
    """The share of pixels that are clearly red."""
    red, green, blue = pixels[..., 0], pixels[..., 1], pixels[..., 2]
    return float(((red > 1.5 * green) & (red > 1.5 * blue) & (red > 0.1)).mean())


def greenness(pixels: np.ndarray) -> float:
    """The share of pixels that are clearly green."""
    return redness(pixels[..., (1, 0, 2)])
