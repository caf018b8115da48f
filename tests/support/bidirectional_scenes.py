"""Small scenes for paths from both ends: materials, lights and cameras of every kind, by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from engine_core.description import (
    Graph,
    Image,
    Link,
    Node,
    Visibility,
    World,
)
from scenes import (
    SceneBuilder,
    background,
    diffuse,
    emission,
    look_at,
    quad,
    shader,
    sphere,
)

Change = Callable[[SceneBuilder], None]
Rgb = tuple[float, float, float]

GREY = (0.6, 0.5, 0.4)


def graph(*nodes: Node, output: str = "BSDF") -> Graph:
    """Nodes of which the last is the surface."""
    return Graph(list(nodes), Link(len(nodes) - 1, output))


def mixed(factor: Node, factor_output: str, first: Node, second: Node) -> Graph:
    """Two closures mixed by what a node says."""
    first_output = "Emission" if first.kind == "ShaderNodeEmission" else "BSDF"
    return graph(
        factor,
        first,
        second,
        Node(
            "ShaderNodeMixShader",
            inputs={
                "Fac": Link(0, factor_output),
                "Shader": Link(1, first_output),
                "Shader_001": Link(2, "BSDF"),
            },
        ),
        output="Shader",
    )


def constant_mix(amount: float, first: Node, second: Node) -> Graph:
    return graph(
        first,
        second,
        Node(
            "ShaderNodeMixShader",
            inputs={"Fac": amount, "Shader": Link(0, "BSDF"), "Shader_001": Link(1, "BSDF")},
        ),
        output="Shader",
    )


def matte(color: tuple[float, float, float] = GREY, roughness: float = 0.0) -> Node:
    return Node("ShaderNodeBsdfDiffuse", inputs={"Color": (*color, 1.0), "Roughness": roughness})


def glossy(roughness: float = 0.4, color: tuple[float, float, float] = (0.8, 0.7, 0.6)) -> Node:
    return Node(
        "ShaderNodeBsdfAnisotropic", inputs={"Color": (*color, 1.0), "Roughness": roughness}
    )


def glass(roughness: float = 0.0, ior: float = 1.45) -> Node:
    inputs = {"Color": (0.9, 0.95, 1.0, 1.0), "Roughness": roughness, "IOR": ior}
    return Node("ShaderNodeBsdfGlass", inputs=inputs)


def clear(amount: float = 0.7) -> Node:
    return Node("ShaderNodeBsdfTransparent", inputs={"Color": (amount, amount, 0.9 * amount, 1.0)})


def translucent() -> Node:
    return Node("ShaderNodeBsdfTranslucent", inputs={"Color": (0.7, 0.5, 0.6, 1.0)})


def bumped(kind: str) -> Graph:
    """A closure on a surface of procedural bumps."""
    return graph(
        Node("ShaderNodeTexCoord"),
        Node("ShaderNodeTexNoise", inputs={"Vector": Link(0, "Object"), "Scale": 3.0}),
        Node("ShaderNodeBump", inputs={"Height": Link(1, "Fac"), "Distance": 0.2}),
        Node(kind, inputs={"Color": (0.7, 0.7, 0.6, 1.0), "Roughness": 0.5,
                           "Normal": Link(2, "Normal")}),
    )  # fmt: skip


def checks(color1: Rgb, color2: Rgb, scale: float) -> tuple[Node, Node]:
    """Two nodes, the second of which is a checkerboard in the object's coordinates."""
    inputs = {"Vector": Link(0, "Object"), "Color1": (*color1, 1.0), "Color2": (*color2, 1.0)}
    return (
        Node("ShaderNodeTexCoord"),
        Node("ShaderNodeTexChecker", inputs={**inputs, "Scale": scale}),
    )


def checkered() -> Graph:
    return graph(
        *checks((0.8, 0.2, 0.2), (0.2, 0.7, 0.3), 3.0),
        Node("ShaderNodeBsdfDiffuse", inputs={"Color": Link(1, "Color")}),
    )


def principled(**inputs: Any) -> Graph:
    return shader("ShaderNodeBsdfPrincipled", **{"Base_Color": (0.8, 0.4, 0.3, 1.0), **inputs})


LIGHT_PATH, GEOMETRY = Node("ShaderNodeLightPath"), Node("ShaderNodeNewGeometry")
FRESNEL = Node("ShaderNodeFresnel", inputs={"IOR": 1.6})
FACING = Node("ShaderNodeLayerWeight", inputs={"Blend": 0.4})

MATERIALS: dict[str, Graph] = {
    "diffuse": diffuse(GREY),
    "oren_nayar": graph(matte(roughness=0.7)),
    "glossy": graph(glossy()),
    "near_mirror": graph(glossy(0.03)),
    "mirror": graph(glossy(0.0)),
    "glass": graph(glass()),
    "rough_glass": graph(glass(0.3)),
    "refraction": shader(
        "ShaderNodeBsdfRefraction", Color=(0.9, 0.9, 0.9, 1.0), Roughness=0.2, IOR=1.4
    ),
    "textured": checkered(),
    "bump_diffuse": bumped("ShaderNodeBsdfDiffuse"),
    "bump_glossy": bumped("ShaderNodeBsdfAnisotropic"),
    "translucent": graph(translucent()),
    "sheen": shader("ShaderNodeBsdfSheen", Color=(0.8, 0.6, 0.7, 1.0), Roughness=0.4),
    "principled": principled(Roughness=0.4, Metallic=0.3),
    "principled_coat": principled(Roughness=0.6, Coat_Weight=0.8, Coat_Roughness=0.1),
    "principled_glass": principled(Roughness=0.2, Transmission_Weight=0.9),
    "principled_alpha": principled(Roughness=0.5, Alpha=0.6),
    "half_clear": constant_mix(0.5, matte(), clear()),
    "diffuse_and_mirror": constant_mix(0.5, matte(), glossy(0.0)),
    "diffuse_and_translucent": constant_mix(0.4, matte(), translucent()),
    "fresnel": mixed(FRESNEL, "Fac", matte(), glossy(0.3)),
    "fresnel_mirror": mixed(FRESNEL, "Fac", matte(), glossy(0.0)),
    "facing": mixed(FACING, "Facing", matte(), glossy(0.2)),
    "facing_clear": mixed(FACING, "Facing", matte(), clear()),
    "facing_mirrors": mixed(
        FACING, "Facing", glossy(0.0, (0.9, 0.2, 0.1)), glossy(0.0, (0.1, 0.3, 0.9))
    ),
    "backfacing": mixed(GEOMETRY, "Backfacing", matte(), translucent()),
    "backfacing_glass": mixed(GEOMETRY, "Backfacing", glass(0.2), matte()),
    "light_path_diffuse": mixed(
        LIGHT_PATH, "Is Camera Ray", matte((0.2, 0.2, 0.6)), matte((0.8, 0.5, 0.2))
    ),
    "light_path_clear": mixed(LIGHT_PATH, "Is Shadow Ray", matte(), clear()),
}


def room(material: Graph | None = None, size: tuple[int, int] = (12, 12)) -> SceneBuilder:
    """A floor and a wall, a coarse ball with smooth normals and a panel; nothing shines."""
    scene = SceneBuilder(size)
    scene.add(quad((-2, -2, 0), (4, 0, 0), (0, 4, 0)), diffuse((0.7, 0.6, 0.5)))
    scene.add(quad((-2, 2, 0), (4, 0, 0), (0, 0, 3)), diffuse((0.4, 0.6, 0.7)))
    chosen = diffuse(GREY) if material is None else material
    scene.add(sphere(0.7, (-0.6, 0.3, 0.8), rings=5), chosen)
    scene.add(quad((0.4, -0.3, 0.2), (1.0, 0.5, 0), (0, 0.3, 1.2)), chosen)
    scene.camera((0.3, -4.5, 2.2), (0, 0.2, 0.7), fov=45)
    return scene


def lamp(kind: str, scene: SceneBuilder, **fields: Any) -> None:
    at = fields.pop("at", (0.8, -0.9, 2.2))
    toward = fields.pop("toward", (0, 0.2, 0.4))
    emitted = fields.pop("emission", (60.0, 50.0, 40.0))
    scene.light(kind, transform=look_at(at, toward), emission=emitted, **fields)


def sky(scene: SceneBuilder) -> None:
    """An image as environment, with a bright patch."""
    pixels = np.full((16, 32, 3), 0.2, np.float32)
    pixels[..., 0] += np.linspace(0, 0.5, 32)[None]
    pixels[11:13, 6:9] = (30.0, 25.0, 20.0)
    scene.description.images.append(Image("sky", pixels, "linear"))
    nodes = [
        Node("ShaderNodeTexCoord"),
        Node("ShaderNodeTexEnvironment", inputs={"Vector": Link(0, "Generated")},
             params={"image": len(scene.description.images) - 1}),
        Node("ShaderNodeBackground", inputs={"Color": Link(1, "Color"), "Strength": 1.0}),
    ]  # fmt: skip
    scene.description.world = World(Graph(nodes, Link(2, "Background")))


def panel(material: Graph, scene: SceneBuilder) -> None:
    scene.add(quad((0.3, -0.8, 1.9), (0.6, 0.1, 0.2), (-0.1, 0.6, 0.1)), material)


def textured_emission() -> Graph:
    return graph(
        *checks((1.0, 0.3, 0.2), (0.1, 0.3, 1.0), 4.0),
        Node("ShaderNodeEmission", inputs={"Color": Link(1, "Color"), "Strength": 20.0}),
        output="Emission",
    )


def facing_emission() -> Graph:
    return graph(
        Node("ShaderNodeLayerWeight", inputs={"Blend": 0.5}),
        Node("ShaderNodeEmission", inputs={"Strength": Link(0, "Facing")}),
        Node("ShaderNodeEmission", inputs={"Strength": 15.0}),
        Node("ShaderNodeAddShader", inputs={"Shader": Link(1, "Emission"),
                                            "Shader_001": Link(2, "Emission")}),
        output="Shader",
    )  # fmt: skip


def one_sided_emission() -> Graph:
    return graph(
        Node("ShaderNodeNewGeometry"),
        Node("ShaderNodeMath", inputs={"Value": Link(0, "Backfacing"), "Value_001": 20.0},
             params={"operation": "MULTIPLY"}),
        Node("ShaderNodeEmission", inputs={"Strength": Link(1, "Value")}),
        output="Emission",
    )  # fmt: skip


def lamp_gradient() -> Graph:
    """Multiplies a lamp by its own parametric coordinates."""
    return graph(
        Node("ShaderNodeNewGeometry"),
        Node("ShaderNodeEmission", inputs={"Color": Link(0, "Parametric"), "Strength": 1.0}),
        output="Emission",
    )


def lamp_falloff() -> Graph:
    return graph(
        Node("ShaderNodeLightFalloff", inputs={"Strength": 1.0}),
        Node("ShaderNodeEmission", inputs={"Strength": Link(0, "Linear")}),
        output="Emission",
    )


def lit(kind: str, **fields: Any) -> Change:
    return partial(lamp, kind, **fields)


def world(strength: float, scene: SceneBuilder) -> None:
    scene.description.world = background(strength, (0.6, 0.8, 1.0))


def many(scene: SceneBuilder) -> None:
    """Lights of several kinds at once."""
    lamp("POINT", scene, radius=0.2, soft_falloff=False)
    lamp("SPOT", scene, at=(-1.5, -1.0, 2.0), radius=0.1, spot_angle=1.0)
    lamp("AREA", scene, at=(-0.5, -1.5, 2.5), size_x=0.6, size_y=0.4)
    lamp("SUN", scene, emission=(1.0, 0.9, 0.8), sun_angle=0.3)
    panel(emission(12.0), scene)
    world(0.2, scene)


NO_GLOSSY = Visibility.ALL & ~Visibility.CAMERA & ~Visibility.GLOSSY
SUN = (1.5, 1.4, 1.2)

LIGHTS: dict[str, Change] = {
    "point": lit("POINT", radius=0.0),
    "point_hard": lit("POINT", radius=0.4, soft_falloff=False),
    "point_soft": lit("POINT", radius=0.4, soft_falloff=True),
    "point_soft_near": lit("POINT", at=(0.1, -0.3, 0.25), radius=0.5, emission=(9, 8, 7)),
    "point_hard_near": lit(
        "POINT", at=(0.1, -0.3, 0.25), radius=0.4, soft_falloff=False, emission=(9, 8, 7)
    ),
    "spot": lit("SPOT", radius=0.0, spot_angle=0.9, spot_blend=0.4),
    "spot_hard": lit("SPOT", radius=0.3, soft_falloff=False, spot_angle=1.0, spot_blend=0.3),
    "spot_soft": lit("SPOT", radius=0.3, soft_falloff=True, spot_angle=1.2, spot_blend=0.5),
    "area": lit("AREA", size_x=0.8, size_y=0.5),
    "area_ellipse": lit("AREA", shape="ELLIPSE", size_x=0.9, size_y=0.5),
    "area_spread": lit("AREA", size_x=0.8, size_y=0.8, spread=1.2),
    "area_ellipse_spread": lit("AREA", shape="ELLIPSE", size_x=0.6, size_y=0.9, spread=0.8),
    "area_parallel": lit("AREA", size_x=0.8, size_y=0.8, spread=0.0),
    "area_tiny": lit("AREA", size_x=1e-4, size_y=1e-4),
    "sun": lit("SUN", emission=SUN, sun_angle=0.0),
    "sun_disk": lit("SUN", emission=SUN, sun_angle=0.5),
    "world": partial(world, 0.8),
    "sky": sky,
    "mesh": partial(panel, emission(15.0)),
    "mesh_textured": partial(panel, textured_emission()),
    "mesh_facing": partial(panel, facing_emission()),
    "mesh_one_sided": partial(panel, one_sided_emission()),
    "lamp_textured": lit("AREA", size_x=0.8, size_y=0.8, graph=lamp_gradient()),
    "point_textured_soft": lit("POINT", radius=0.4, graph=lamp_gradient()),
    "point_textured_hard": lit("POINT", radius=0.4, soft_falloff=False, graph=lamp_gradient()),
    "spot_textured": lit("SPOT", radius=0.2, spot_angle=1.0, graph=lamp_gradient()),
    "lamp_falloff": lit("POINT", radius=0.2, graph=lamp_falloff()),
    "no_mis": lit("AREA", size_x=0.8, size_y=0.5, use_mis=False),
    "no_shadow": lit("POINT", radius=0.2, cast_shadow=False),
    "hidden_from_glossy": lit("AREA", size_x=0.8, size_y=0.5, visibility=int(NO_GLOSSY)),
    "many": many,
}


#: Lights that paths do not start from: they shine through walls, on some lobes only, or otherwise
#: on each receiver.
NOT_EMITTED = {
    "no_shadow",
    "hidden_from_glossy",
    "lamp_falloff",
    "point_textured_soft",
    "spot_textured",
}


def camera(scene: SceneBuilder, **fields: Any) -> None:
    eye = fields.pop("eye", (0.3, -4.5, 2.2))
    scene.camera(eye, (0, 0.2, 0.7), fov=45, **fields)


def orthographic(scene: SceneBuilder, **fields: Any) -> None:
    camera(scene, kind="ORTHOGRAPHIC", **fields)
    scene.description.camera.window = (-1.9, 1.9, -1.9, 1.9)


def crop(scene: SceneBuilder) -> None:
    scene.description.film.crop = (3, 2, 10, 8)


CAMERAS: dict[str, Change] = {
    "pinhole": camera,
    "focus": partial(camera, aperture_radius=0.15, focus_distance=4.0),
    "focus_blades": partial(
        camera, aperture_radius=0.2, focus_distance=4.0, blades=5, blade_rotation=0.3,
        aperture_ratio=1.6,
    ),
    "orthographic": orthographic,
    "orthographic_focus": partial(orthographic, aperture_radius=0.15, focus_distance=4.0),
    "clipped": partial(camera, clip_start=4.0, clip_end=6.5),
    "crop": crop,
    "in_a_lamp": partial(
        lamp, "POINT", at=(0.3, -4.5, 2.2), radius=0.6, soft_falloff=False, emission=(60, 60, 60)
    ),
}  # fmt: skip


def camera_only_sheet(scene: SceneBuilder) -> None:
    """A sheet before the camera that nothing else sees, and a ball that the camera does not."""
    scene.add(
        quad((-1, -3, 0.5), (2, 0, 0), (0, 0, 2)),
        constant_mix(0.6, matte(), clear(0.9)),
        visibility=int(Visibility.CAMERA),
    )
    scene.add(
        sphere(0.4, (0.9, -0.6, 0.4), rings=6),
        diffuse(0.6),
        visibility=int(Visibility.ALL & ~Visibility.CAMERA),
    )


def clear_sheet(material: Graph, scene: SceneBuilder) -> None:
    """A sheet between the lamps and the floor."""
    scene.add(quad((-1.5, -1.5, 1.7), (3, 0, 0), (0, 3, 0)), material)


EXTRAS: dict[str, Change] = {
    "camera_only": camera_only_sheet,
    "clear_sheet": partial(clear_sheet, MATERIALS["half_clear"]),
    "facing_sheet": partial(clear_sheet, MATERIALS["facing_clear"]),
    "light_path_sheet": partial(clear_sheet, MATERIALS["light_path_clear"]),
}


def build(
    material: str = "diffuse",
    light: str = "area",
    view: str = "pinhole",
    extra: str = "",
    size: tuple[int, int] = (12, 12),
) -> SceneBuilder:
    """The room, by the names of what is in it."""
    scene = room(MATERIALS[material], size)
    LIGHTS[light](scene)
    CAMERAS[view](scene)
    if extra:
        EXTRAS[extra](scene)
    return scene


def scaled(scene: SceneBuilder, scale: float, offset: float = 0.0) -> SceneBuilder:
    """The same scene, every length `scale` times as long, and moved along all axes.

    Lamps shine by the area's square, so that the picture stays; suns and worlds need nothing.
    """
    d = scene.description
    for matrices in (d.instances.transform, d.camera.transform[None]):
        matrices[:, :, 3] = matrices[:, :, 3] * scale + offset
    d.instances.transform[:, :, :3] *= scale
    camera = d.camera
    assert camera is not None
    if camera.kind == "ORTHOGRAPHIC":
        camera.window = tuple(w * scale for w in camera.window)
    for name in ("clip_start", "clip_end", "aperture_radius", "focus_distance"):
        setattr(camera, name, getattr(camera, name) * scale)
    for light in d.lights:
        light.transform[:, 3] = light.transform[:, 3] * scale + offset
        for name in ("radius", "size_x", "size_y"):
            setattr(light, name, getattr(light, name) * scale)
        if light.kind != "SUN":
            r, g, b = light.emission
            light.emission = (r * scale**2, g * scale**2, b * scale**2)
    return scene


def apart(light: str, view: str, material: str = "glossy") -> SceneBuilder:
    """Surfaces that keep their distance, so that every technique alone has a finite variance."""
    scene = SceneBuilder((12, 12))
    scene.add(quad((-2, -2, -0.3), (4, 0, 0), (0, 4, 0)), diffuse((0.7, 0.6, 0.5)))
    scene.add(sphere(0.7, (-0.7, 0.2, 1.2), rings=6), MATERIALS[material])
    scene.add(quad((0.6, -0.2, 0.5), (1.0, 0.6, 0.1), (0, 0.3, 1.1)), diffuse((0.5, 0.6, 0.8)))
    scene.camera((0.3, -4.5, 2.2), (0, 0.2, 0.7), fov=45)
    LIGHTS[light](scene)
    CAMERAS[view](scene)
    return scene
