"""Materials by name, each a function that makes it in Blender: closures and Principled's inputs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

Maker = Callable[[str], Any]


def _single(kind: str, inputs: dict[str, Any], settings: dict[str, Any], name: str) -> Any:
    from blend_scenes.authoring.materials import closure

    return closure(name, kind, inputs, **settings)


def one(kind: str, inputs: dict[str, Any] | None = None, **settings: Any) -> Maker:
    """A material of one closure node."""
    return partial(_single, kind, inputs or {}, settings)


RED = (0.8, 0.3, 0.2)


def principled(**inputs: Any) -> Maker:
    """Principled with a red base; underscores in names of inputs stand for blanks."""
    named = {name.replace("_", " "): value for name, value in inputs.items()}
    return one("BsdfPrincipled", {"Base Color": RED, **named})


def _combined(kind: str, name: str) -> Any:
    """Mixes and sums of closures."""
    from blend_scenes.authoring.materials import new_material

    material, nodes = new_material(name)
    first = nodes.add("BsdfDiffuse", {"Color": RED}).outputs[0]
    second = nodes.add("BsdfGlossy", {"Color": (0.4, 0.4, 0.5), "Roughness": 0.3}).outputs[0]
    if kind == "mix":
        surface = nodes.add("MixShader", {0: 0.3, 1: first, 2: second}).outputs[0]
    elif kind == "fresnel":
        factor = nodes.add("Fresnel", {"IOR": 1.5}).outputs[0]
        surface = nodes.add("MixShader", {0: factor, 1: first, 2: second}).outputs[0]
    elif kind == "add":
        surface = nodes.add("AddShader", {0: first, 1: second}).outputs[0]
    else:
        hole = nodes.add("BsdfTransparent", {"Color": (0.9, 0.6, 0.9)}).outputs[0]
        surface = nodes.add("MixShader", {0: 0.5, 1: first, 2: hole}).outputs[0]
    nodes.output(surface)
    return material


def _bumped(kind: str, shader: str, inputs: dict[str, Any], name: str) -> Any:
    """A closure whose normal is bent, by bumps of a noise or by a normal map's one colour."""
    from blend_scenes.authoring.materials import new_material

    material, nodes = new_material(name)
    if kind == "bump":
        place = nodes.coordinates("Object")
        noise = nodes.add("TexNoise", {"Vector": place, "Scale": 8.0, "Detail": 1.0})
        bent = nodes.add(
            "Bump", {"Height": noise.outputs[0], "Strength": 0.6, "Distance": 0.05}
        ).outputs[0]
    else:
        bent = nodes.add("NormalMap", {"Color": (0.65, 0.4, 0.9), "Strength": 0.8}).outputs[0]
    nodes.output(nodes.add(shader, {**inputs, "Normal": bent}).outputs[0])
    return material


def bent(kind: str, shader: str, **inputs: Any) -> Maker:
    named = {name.replace("_", " "): value for name, value in inputs.items()}
    return partial(_bumped, kind, shader, named)


CASES: dict[str, Maker] = {
    "diffuse": one("BsdfDiffuse", {"Color": RED}),
    "oren_nayar": one("BsdfDiffuse", {"Color": RED, "Roughness": 0.8}),
    "translucent": one("BsdfTranslucent", {"Color": RED}),
    "transparent": one("BsdfTransparent", {"Color": RED}),
    "emission": one("Emission", {"Color": RED, "Strength": 0.7}),
    "mix": partial(_combined, "mix"),
    "mix_by_fresnel": partial(_combined, "fresnel"),
    "add": partial(_combined, "add"),
    "half_transparent": partial(_combined, "hole"),
    **{
        f"glossy_{kind.lower()}_{rough}": one(
            "BsdfAnisotropic", {"Color": RED, "Roughness": rough}, distribution=kind
        )
        for kind in ("GGX", "MULTI_GGX", "BECKMANN", "ASHIKHMIN_SHIRLEY")
        for rough in (0.2, 0.6)
    },
    "glossy_smooth": one("BsdfAnisotropic", {"Color": RED, "Roughness": 0.0}),
    "glossy_anisotropic": one(
        "BsdfAnisotropic", {"Color": RED, "Roughness": 0.4, "Anisotropy": 0.7, "Rotation": 0.1}
    ),
    **{
        f"glass_{kind.lower()}_{rough}": one(
            "BsdfGlass",
            {"Color": (0.9, 0.8, 1.0), "Roughness": rough, "IOR": 1.5},
            distribution=kind,
        )
        for kind in ("GGX", "MULTI_GGX", "BECKMANN")
        for rough in (0.0, 0.3, 0.8)
    },
    "glass_low_ior": one("BsdfGlass", {"Roughness": 0.2, "IOR": 0.8}),
    "refraction_smooth": one("BsdfRefraction", {"Color": RED, "Roughness": 0.0, "IOR": 1.4}),
    "refraction_rough": one("BsdfRefraction", {"Color": RED, "Roughness": 0.4, "IOR": 1.4}),
    "metallic_f82": one("BsdfMetallic", {"Roughness": 0.3}, fresnel_type="F82"),
    "metallic_conductor": one(
        "BsdfMetallic", {"Roughness": 0.3}, fresnel_type="PHYSICAL_CONDUCTOR"
    ),
    "sheen_microfiber": one("BsdfSheen", {"Color": RED, "Roughness": 0.5}),
    "sheen_ashikhmin": one("BsdfSheen", {"Color": RED, "Roughness": 0.5}, distribution="ASHIKHMIN"),
    "principled": principled(),
    "principled_rough": principled(Roughness=1.0, Diffuse_Roughness=0.7),
    "principled_smooth": principled(Roughness=0.0),
    "principled_metal": principled(Metallic=1.0, Roughness=0.4),
    "principled_half_metal": principled(Metallic=0.5, Roughness=0.3),
    "principled_metal_tint": principled(
        Metallic=1.0, Roughness=0.3, Specular_Tint=(0.2, 0.9, 0.4, 1.0)
    ),
    "principled_transmission": principled(Transmission_Weight=1.0, Roughness=0.0),
    "principled_rough_transmission": principled(Transmission_Weight=1.0, Roughness=0.5),
    "principled_half_transmission": principled(Transmission_Weight=0.5, Roughness=0.2, IOR=1.3),
    "principled_alpha": principled(Alpha=0.4),
    "principled_ior": principled(IOR=2.2, Roughness=0.3),
    "principled_specular": principled(Specular_IOR_Level=0.9, Specular_Tint=(0.3, 0.9, 0.5, 1.0)),
    "principled_no_specular": principled(Specular_IOR_Level=0.0),
    "principled_coat": principled(Coat_Weight=1.0, Coat_Roughness=0.1),
    "principled_coat_tint": principled(
        Coat_Weight=0.7, Coat_Roughness=0.4, Coat_IOR=1.8, Coat_Tint=(0.9, 0.7, 0.3, 1.0)
    ),
    "principled_coated_metal": principled(Metallic=1.0, Coat_Weight=0.8, Coat_Roughness=0.2),
    "principled_sheen": principled(Sheen_Weight=1.0, Sheen_Roughness=0.4, Roughness=0.8),
    "principled_sheen_tint": principled(
        Sheen_Weight=0.6, Sheen_Roughness=0.8, Sheen_Tint=(0.3, 0.5, 1.0, 1.0)
    ),
    "principled_anisotropic": principled(
        Metallic=1.0, Roughness=0.4, Anisotropic=0.8, Anisotropic_Rotation=0.15
    ),
    "principled_emission": principled(Emission_Color=(0.2, 0.6, 1.0, 1.0), Emission_Strength=0.8),
    "principled_thin_film": principled(
        Thin_Film_Thickness=500.0, Thin_Film_IOR=1.6, Roughness=0.2, IOR=1.8
    ),
    "principled_film_metal": principled(
        Metallic=1.0, Thin_Film_Thickness=350.0, Thin_Film_IOR=1.4, Roughness=0.2
    ),
    "principled_all": principled(
        Metallic=0.3,
        Roughness=0.4,
        Coat_Weight=0.5,
        Sheen_Weight=0.4,
        Transmission_Weight=0.3,
        Emission_Color=(0.1, 0.2, 0.3, 1.0),
        Emission_Strength=0.5,
    ),
    "diffuse_bump": bent("bump", "BsdfDiffuse", Color=RED),
    "principled_bump": bent("bump", "BsdfPrincipled", Base_Color=RED, Roughness=0.3),
    "glossy_bump": bent("bump", "BsdfGlossy", Color=RED, Roughness=0.2),
    "glass_bump": bent("bump", "BsdfGlass", Roughness=0.2),
    "translucent_bump": bent("bump", "BsdfTranslucent", Color=RED),
    "rug": bent(
        "bump",
        "BsdfPrincipled",
        Base_Color=RED,
        Roughness=0.95,
        Sheen_Weight=0.5,
        Sheen_Roughness=0.4,
    ),
    "diffuse_normal_map": bent("map", "BsdfDiffuse", Color=RED),
    "principled_normal_map": bent("map", "BsdfPrincipled", Base_Color=RED, Roughness=0.3),
    "principled_metal_normal_map": bent(
        "map", "BsdfPrincipled", Base_Color=RED, Metallic=1.0, Roughness=0.3
    ),
}

# Those with rough refraction, which Cycles lights wrongly by light samples.
BSDF_SAMPLED = {
    name
    for name in CASES
    if name.startswith("glass_")
    or name in ("principled_rough_transmission", "principled_all")
    or name in ("principled_half_transmission", "refraction_rough")
}
