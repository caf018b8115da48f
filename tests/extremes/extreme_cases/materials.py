"""Roughness down to 1e-6 and refraction near 1, 1e-3 and 1e3: continuous, and nothing created."""

from __future__ import annotations

from functools import partial

from bidirectional_scenes import GREY, SUN, glass, glossy, graph, lamp, mixed, principled, room
from engine_core.description import Graph, Link, Node
from scenes import SceneBuilder, background, quad, shader, sphere

from extreme_cases.case import AtMost, Case, Finite, Needs, Same, Truth, power_of_ten

ROUGHNESSES = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0)
WHITE = (1.0, 1.0, 1.0)


def metal(roughness: float) -> Graph:
    return principled(Metallic=1.0, Roughness=roughness)


def coat(roughness: float) -> Graph:
    return principled(Roughness=0.5, Coat_Weight=1.0, Coat_Roughness=roughness)


def rough_diffuse(roughness: float) -> Graph:
    return shader("ShaderNodeBsdfDiffuse", Color=(*GREY, 1.0), Roughness=roughness)


KINDS = {
    "glossy": lambda roughness: graph(glossy(roughness)),
    "glass": lambda roughness: graph(glass(roughness)),
    "metal": metal,
    "coat": coat,
}


def lit(material: Graph) -> SceneBuilder:
    """Lit by large and even lights, whose image in a polished surface hardly blurs."""
    scene = room(material)
    lamp("AREA", scene, size_x=1.5, size_y=1.5)
    scene.description.world = background(0.5)
    return scene


def rough(kind: str, roughness: float) -> SceneBuilder:
    return lit(KINDS[kind](roughness))


def oren_nayar(roughness: float) -> SceneBuilder:
    return lit(rough_diffuse(roughness))


def white_ball(material: Graph) -> SceneBuilder:
    """Alone under an even sky of radiance 1, as large as the picture."""
    scene = SceneBuilder((4, 4))
    scene.add(sphere(1.0, rings=24), material)
    scene.camera((0, -3, 0), (0, 0, 0), fov=30)
    scene.description.world = background(1.0)
    return scene


def white_glossy(roughness: float) -> SceneBuilder:
    return white_ball(graph(glossy(roughness, WHITE)))


def white_glass(roughness: float, ior: float) -> SceneBuilder:
    inputs = {"Color": (1.0, 1.0, 1.0, 1.0), "Roughness": roughness, "IOR": ior}
    return white_ball(graph(Node("ShaderNodeBsdfGlass", inputs=inputs)))


def white_principled(roughness: float, ior: float) -> SceneBuilder:
    return white_ball(
        principled(Base_Color=(1.0, 1.0, 1.0, 1.0), Roughness=roughness, IOR=ior, Coat_Weight=0.5)
    )


def through(ior: float, roughness: float = 0.0) -> SceneBuilder:
    """A ball of glass before a wall of two colours, under a sky."""
    scene = SceneBuilder((12, 12))
    colors = mixed(
        Node("ShaderNodeTexChecker", inputs={"Scale": 1.5}),
        "Fac",
        Node("ShaderNodeBsdfDiffuse", inputs={"Color": (0.8, 0.3, 0.2, 1.0)}),
        Node("ShaderNodeBsdfDiffuse", inputs={"Color": (0.2, 0.4, 0.8, 1.0)}),
    )
    scene.add(quad((-3, 2, -3), (6, 0, 0), (0, 0, 6)), colors)
    if ior:
        inputs = {"Color": (1.0, 1.0, 1.0, 1.0), "Roughness": roughness, "IOR": ior}
        scene.add(sphere(1.0, rings=16), graph(Node("ShaderNodeBsdfGlass", inputs=inputs)))
    scene.description.world = background(1.0)
    scene.camera((0, -4, 0.3), (0, 0, 0), fov=45)
    return scene


def sun_on_glossy(roughness: float) -> SceneBuilder:
    """The least light in the sharpest lobe."""
    scene = room(graph(glossy(roughness)))
    lamp("SUN", scene, emission=SUN, sun_angle=0.0)
    lamp("POINT", scene, radius=0.0)
    return scene


def five_thousand_nodes(depth: int) -> SceneBuilder:
    """A chain whose end is its beginning: colours inverted an even number of times."""
    nodes = [
        Node(
            "ShaderNodeInvert",
            inputs={"Fac": 1.0, "Color": Link(i - 1, "Color") if i else (0.6, 0.5, 0.4, 1.0)},
        )
        for i in range(depth)
    ]
    nodes.append(Node("ShaderNodeBsdfDiffuse", inputs={"Color": Link(depth - 1, "Color")}))
    return lit(Graph(nodes, Link(depth, "BSDF")))


def cases() -> list[Case]:
    found = []
    four: dict[str, object] = {"max_bounces": 4}
    polished = Needs.POLISHED | Needs.ALL_LIGHT
    for roughness in ROUGHNESSES:
        name = f"roughness {power_of_ten(roughness)}"
        for kind in KINDS:
            small = roughness <= 1e-3
            found.append(
                Case(
                    "materials",
                    f"{kind} of {name}",
                    partial(rough, kind, roughness),
                    # Where a lobe is sharp its picture is that of the mirror.
                    Same(partial(rough, kind, 0.0), slack=2e-3)
                    if small
                    else Same(partial(rough, kind, roughness), of_paths=True),
                    polished if roughness <= 0.1 else Needs.ALL_LIGHT,
                    four,
                    # What blurred glass focuses is rare and bright: few samples never meet it.
                    samples=256 if kind == "glass" and not small else 8,
                )
            )
        found.append(
            Case("materials", f"diffuse of {name}", partial(oren_nayar, roughness),
                 Same(partial(oren_nayar, 0.0), slack=2e-3) if roughness <= 1e-3
                 else Same(partial(oren_nayar, roughness), of_paths=True),
                 Needs.ALL_LIGHT, four)
        )  # fmt: skip
        bright = {"max_bounces": 200}
        found.append(
            Case("materials", f"white glossy of {name} in a furnace",
                 partial(white_glossy, roughness), AtMost(1.0, 4e-3), polished, bright)
        )  # fmt: skip
        found.append(
            Case("materials", f"white glass of {name} in a furnace",
                 partial(white_glass, roughness, 1.45), AtMost(1.0, 4e-3), polished, bright)
        )  # fmt: skip
        found.append(
            Case("materials", f"white principled of {name} in a furnace",
                 partial(white_principled, roughness, 1.5), AtMost(1.0, 4e-3), polished, bright)
        )  # fmt: skip
        found.append(
            Case("materials", f"points on glossy of {name}", partial(sun_on_glossy, roughness),
                 Finite(), settings=four)
        )  # fmt: skip
    for ior in (1 - 1e-6, 1.0, 1 + 1e-6):
        found.append(
            Case("materials", f"glass of IOR {ior!r} is not there", partial(through, ior),
                 Same(partial(through, 0.0), slack=1e-3), polished,
                 {"max_bounces": 12, "diffuse_bounces": 1})
        )  # fmt: skip
    for ior in (1e-3, 0.5, 1 - 1e-6, 1.0, 1 + 1e-6, 2.5, 1e3):
        for roughness in (0.0, 1e-3, 0.3):
            name = f"IOR {ior!r}, roughness {power_of_ten(roughness)}"
            smooth = roughness == 0.0
            found.append(
                Case("materials", f"white glass of {name} in a furnace",
                     partial(white_glass, roughness, ior),
                     Truth(1.0) if smooth and 0.4 < ior < 3 else AtMost(1.0, 4e-3), polished,
                     {"max_bounces": 400})
            )  # fmt: skip
        found.append(
            Case("materials", f"white principled of IOR {ior!r} in a furnace",
                 partial(white_principled, 0.3, ior), AtMost(1.0, 4e-3), polished,
                 {"max_bounces": 200})
        )  # fmt: skip
    found.append(
        Case("materials", "a chain of 5,000 nodes", partial(five_thousand_nodes, 5000),
             Same(partial(five_thousand_nodes, 2), slack=2e-3), settings=four)
    )  # fmt: skip
    return found
