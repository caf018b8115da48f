"""Closed rooms whose walls return what they absorb: their radiance is known after any bounces."""

from __future__ import annotations

from functools import partial

from engine_core.description import Graph, Link, Mesh, Node
from scenes import SceneBuilder, box

from extreme_cases.case import Case, Needs, Truth, power_of_ten


def walls(albedo: float, emitted: float) -> Graph:
    """Matte and shining."""
    return Graph(
        [
            Node("ShaderNodeBsdfDiffuse", inputs={"Color": (albedo, albedo, albedo, 1.0)}),
            Node("ShaderNodeEmission", inputs={"Strength": emitted}),
            Node("ShaderNodeAddShader", inputs={"Shader": Link(0, "BSDF"),
                                                "Shader_001": Link(1, "Emission")}),
        ],
        Link(2, "Shader"),
    )  # fmt: skip


def furnace(
    albedo: float, emitted: float, shape: Mesh | None = None, size: int = 4
) -> SceneBuilder:
    """A camera in the middle of a room of side 2 about the origin."""
    scene = SceneBuilder((size, size))
    room = box((-1, -1, -1), (1, 1, 1), inward=True) if shape is None else shape
    scene.add(room, walls(albedo, emitted))
    scene.camera((0.1, -0.4, 0.05), (0.3, 0.5, 0.1), fov=70)
    return scene


def after(bounces: int, albedo: float, emitted: float) -> float:
    """sum of emitted * albedo^k for k up to bounces + 1 surfaces behind the first."""
    terms = bounces + 2
    return emitted * (terms if albedo == 1.0 else (1.0 - albedo**terms) / (1.0 - albedo))


def unlimited(bounces: int) -> dict[str, object]:
    return {"max_bounces": bounces, "roulette_threshold": 0.0}


def cases() -> list[Case]:
    found = []
    for albedo in (0.0, 1e-6, 0.5, 0.9, 0.99, 0.999, 1.0):
        for bounces in (0, 1, 10, 100, 1000, 10000):
            if bounces > 100 and albedo < 0.9:
                continue  # the same as a hundred to the last bit
            emitted = 1.0 - albedo if albedo < 1.0 else 1.0 / (bounces + 2)
            found.append(
                Case(
                    "furnace",
                    f"albedo {power_of_ten(albedo)}, {bounces} bounces",
                    partial(furnace, albedo, emitted, None, 2 if bounces > 100 else 4),
                    Truth(after(bounces, albedo, emitted)),
                    Needs.ALL_LIGHT,
                    unlimited(bounces),
                    samples=4 if bounces <= 100 else 1,
                    deep=bounces > 10,
                    not_joined=bounces > 1000,
                )
            )
    return found
