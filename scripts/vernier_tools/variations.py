"""Variations of a scene description: the same difficulties, arranged otherwise."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from engine_core.description import SceneDescription

#: How far lamps are moved, of the distance between them and the camera.
SHIFT = 0.15
#: What is added to constant roughness.
ROUGHER = 0.15


def moved_lamps(description: SceneDescription) -> SceneDescription:
    """Lamps shifted sideways, each in a direction of its own. Meshes that glow stay."""
    result = copy.deepcopy(description)
    if result.camera is None:
        return result
    camera = result.camera.transform[:, 3]
    for number, light in enumerate(result.lights):
        angle = 2.4 * number
        direction = np.array([np.cos(angle), np.sin(angle), 0.0], np.float32)
        distance = float(np.linalg.norm(light.transform[:, 3] - camera))
        light.transform = light.transform.copy()
        light.transform[:, 3] += np.float32(SHIFT * distance) * direction
    return result


def rougher(description: SceneDescription) -> SceneDescription:
    """Constant roughness of all materials raised."""
    result = copy.deepcopy(description)
    for material in result.materials:
        for node in material.graph.nodes:
            value = node.inputs.get("Roughness")
            if isinstance(value, int | float):
                node.inputs["Roughness"] = min(float(value) + ROUGHER, 1.0)
    return result


def variations(description: SceneDescription) -> Iterator[tuple[str, SceneDescription]]:
    """What has been changed, and the scene."""
    if description.lights:
        yield "lamps moved", moved_lamps(description)
    yield "rougher", rougher(description)
