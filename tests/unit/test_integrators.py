"""What every integrator owes: all passes, finite, and an end when it is asked for."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
from engine_core.description import Film, Graph, Link, Node, Visibility, World
from scenes import (
    SceneBuilder,
    background,
    diffuse,
    emission,
    picture,
    placed,
    quad,
    shader,
    sphere,
)

import engine_core
from engine_core import probe

INTEGRATORS = [
    identifier
    for parameter in engine_core.parameters()
    if parameter.name == "integrator"
    for identifier, *_ in parameter.items
]
FEW_PHOTONS = {"global_photons": 1000, "caustic_photons": 1000}
PASSES = [info.name for info in engine_core.passes()]


def scene() -> Any:
    """Lamps and materials of every sort, seen through a lens, on part of the frame."""
    builder = SceneBuilder((40, 36))
    builder.description.film = Film(40, 36, crop=(3, 2, 38, 36), transparent=True)
    builder.camera((0, -6, 3), (0, 0, 0.6), aperture_radius=0.05, focus_distance=6.0, blades=5)
    builder.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse((0.7, 0.5, 0.3)))
    principled = shader(
        "ShaderNodeBsdfPrincipled", Base_Color=(0.5, 0.6, 0.8, 1.0), Alpha=0.7, Coat_Weight=0.5
    )
    builder.add(sphere(0.8, (-1, 0, 0.8), rings=12), principled)
    glass = shader("ShaderNodeBsdfGlass", Color=(1.0, 1.0, 1.0, 1.0), Roughness=0.0, IOR=1.5)
    builder.add(sphere(0.7, (1, -0.5, 0.7), rings=12), glass)
    builder.add(quad((-1, -1, 4), (0, 2, 0), (2, 0, 0)), emission(5.0))
    builder.light("POINT", transform=placed(1.0, (2, -2, 3)), emission=(60.0,) * 3)
    builder.light("SPOT", transform=placed(1.0, (-2, -2, 3)), emission=(60.0,) * 3, radius=0.1)
    builder.light("SUN", emission=(1.0,) * 3, sun_angle=0.1)
    builder.description.world = background(0.3)
    return engine_core.compile(builder.description, threads=2, keep_uv=True)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_sky_that_only_the_camera_sees(integrator: str) -> None:
    """It shines, and there is nothing of it that light sampling could find."""
    builder = SceneBuilder((16, 16))
    builder.camera((0, -6, 1), (0, 0, 1))
    builder.add(quad((-3, -3, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.5))
    builder.light("POINT", transform=placed(1.0, (2, -2, 3)), emission=(60.0,) * 3)
    inputs = {"Color": (0.25, 0.5, 1.0, 1.0), "Strength": Link(0, "Is Camera Ray")}
    nodes = [Node("ShaderNodeLightPath"), Node("ShaderNodeBackground", inputs=inputs)]
    builder.description.world = World(Graph(nodes, Link(1, "Background")))
    sky = picture(builder, integrator=integrator, samples=4, threads=2, **FEW_PHOTONS)[-1]
    np.testing.assert_allclose(sky, np.broadcast_to((0.25, 0.5, 1.0), sky.shape), rtol=1e-4)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_all_passes_are_finite(integrator: str) -> None:
    compiled = scene()
    session = engine_core.Session(
        compiled,
        {"integrator": integrator, "samples": 6, "threads": 3, **FEW_PHOTONS},
        PASSES,
    )
    session.start()
    while not session.wait(10.0):
        pass
    assert session.error_message == ""
    progress = session.poll(True)
    assert progress.non_finite == 0
    assert progress.samples == 6
    width, height = 35, 34
    for name in PASSES:
        assert np.isfinite(session.read(name, 0, 0, width, height)).all(), name
    assert session.read("Combined", 0, 0, width, height)[..., :3].mean() > 0.05


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_render_can_be_cancelled_at_any_moment(integrator: str) -> None:
    compiled = scene()
    settings = {"integrator": integrator, "samples": 1 << 24, "threads": 3}
    for moment in np.random.default_rng(3).uniform(0.0, 0.15, 8):
        session = engine_core.Session(compiled, settings, ["Combined", "Error"])
        session.start()
        time.sleep(moment)
        session.cancel()
        assert session.wait(20.0)
        assert session.error_message == ""


@pytest.mark.parametrize("integrator", ["PSSMLT", "MMLT", "MLT"])
def test_a_chain_may_be_cancelled_before_it_has_a_start(integrator: str) -> None:
    assert probe.cancelled_start(scene(), {"integrator": integrator}) == [0.0, 0.0]


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_what_was_cut_short_can_be_gone_on_with(integrator: str) -> None:
    """Lists that are empty, sums of nothing and paths without an end: from no time at all to more
    than there is to do."""
    settings = {"integrator": integrator, "samples": 64, "threads": 2, **FEW_PHOTONS}
    compiled = scene()
    assert probe.cut_short(compiled, settings, 0.0) <= 2 * 35 * 34  # what is traced is cut at once
    for seconds in np.geomspace(1e-4, 0.3, 12):
        probe.cut_short(compiled, settings, float(seconds))


def limited(
    compiled: Any, integrator: str, seconds: float, **settings: Any
) -> tuple[Any, list[str]]:
    """A render that time ends, and what it then has to say of that."""
    limits = {"integrator": integrator, "threads": 2, "samples": 1 << 20, "time_limit": seconds}
    session = engine_core.Session(compiled, {**limits, **FEW_PHOTONS, **settings}, ["Combined"])
    known = list(session.notes)
    session.start()
    while not session.wait(10.0):
        pass
    progress = session.poll()
    assert progress.ending == "time"
    return progress, [note for note in session.notes if note not in known]


def white_room() -> Any:
    """Closed, and absorbs nothing: without roulette its paths take as long as they may."""
    builder = SceneBuilder((8, 8))
    builder.camera((0, 0, 0), (0, 1, 0))
    builder.add(sphere(1.0, (0, 0, 0), rings=12), diffuse(1.0))
    builder.light("POINT", transform=placed(1.0, (0.2, 0, 0.5)), emission=(1.0,) * 3)
    return engine_core.compile(builder.description, threads=1)


@pytest.mark.parametrize("integrator", ["PATH", "BDPT", "PHOTON", "SPPM", "MLT"])
def test_a_time_limit_that_leaves_an_empty_picture_says_so(integrator: str) -> None:
    # On a busy machine the clock is looked at late: path tracing, which has nothing to prepare,
    # must not be done with a tile before.
    endless = {"roulette_threshold": 0.0, "max_bounces": 1 << 16} if integrator == "PATH" else {}
    compiled = white_room() if integrator == "PATH" else scene()
    renders = (limited(compiled, integrator, 1e-6, **endless) for _ in range(20))
    told = next(said for progress, said in renders if progress.samples == 0)
    assert len(told) == 1
    assert "time limit" in told[0]
    assert "the picture is empty" in told[0]


def test_a_time_limit_that_leaves_a_picture_says_nothing() -> None:
    compiled = scene()
    # However slow the machine is, some limit leaves time for a pass.
    renders = (limited(compiled, "SPPM", 0.25 * 2.0**attempt) for attempt in range(10))
    told = next(said for progress, said in renders if progress.samples >= 1)
    assert not [note for note in told if "time limit" in note]


def notes(visibility: Visibility = Visibility.ALL, **settings: Any) -> list[str]:
    builder = SceneBuilder((4, 4))
    builder.add(quad((-1, -1, 0), (2, 0, 0), (0, 2, 0)), diffuse(0.5), visibility=visibility)
    builder.light("POINT", transform=placed(1.0, (0, 0, 2)), emission=(10.0,) * 3)
    builder.camera((0, -4, 3), (0, 0, 0))
    compiled = engine_core.compile(builder.description, threads=1)
    return list(engine_core.Session(compiled, settings, ["Combined"]).notes)


@pytest.mark.parametrize("integrator", ["BDPT", "LIGHT"])
def test_what_is_left_out_is_named(integrator: str) -> None:
    assert notes(integrator=integrator) == []
    assert notes(integrator=integrator, diffuse_bounces=2) == []
    hidden = Visibility.ALL & ~Visibility.GLOSSY
    (uneven,) = notes(hidden, integrator=integrator)
    assert "hidden" in uneven
    assert notes(hidden, integrator="PATH", diffuse_bounces=2) == []


@pytest.mark.parametrize("integrator", ["LIGHT", "PHOTON", "SPPM"])
def test_sides_that_let_light_through_apart_are_named(integrator: str) -> None:
    """Matte in front and translucent behind: light from the front never comes through."""
    nodes = [
        Node("ShaderNodeNewGeometry"),
        Node("ShaderNodeBsdfDiffuse"),
        Node("ShaderNodeBsdfTranslucent"),
        Node("ShaderNodeMixShader", inputs={"Fac": Link(0, "Backfacing"), "Shader": Link(1, "BSDF"),
                                            "Shader_001": Link(2, "BSDF")}),
    ]  # fmt: skip
    builder = SceneBuilder((4, 4))
    builder.add(quad((-1, -1, 0), (2, 0, 0), (0, 2, 0)), Graph(nodes, Link(3, "Shader")))
    builder.light("POINT", transform=placed(1.0, (0, 0, 2)), emission=(10.0,) * 3)
    builder.camera((0, -4, 3), (0, 0, 0))
    compiled = engine_core.compile(builder.description, threads=1)
    found = engine_core.Session(compiled, {"integrator": integrator}, ["Combined"]).notes
    assert any("other side alone is left out" in note for note in found)
    assert not any("other side" in note for note in notes(integrator=integrator))
    by_camera = engine_core.Session(compiled, {"integrator": "BDPT"}, ["Combined"]).notes
    assert list(by_camera) == []


def test_what_chains_do_not_clamp_is_named() -> None:
    assert notes(integrator="MLT") == []
    (clamped,) = notes(integrator="MLT", clamp_indirect=2.0)
    assert "Clamp Indirect has no effect" in clamped
    assert notes(integrator="MLT", clamp_direct=2.0) == []
    (both,) = notes(integrator="MLT", clamp_direct=2.0, clamp_indirect=2.0, separate_direct=0)
    assert "Clamp Direct and Clamp Indirect have no effect" in both
    assert notes(integrator="PSSMLT", clamp_indirect=2.0) == []
