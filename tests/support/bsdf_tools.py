"""Surfaces and directions for the tests of scattering, and samples by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine_core import probe

Array = NDArray[np.float64]
Surface = dict[str, Any]

REFLECTION, TRANSMISSION, SINGULAR, TRANSPARENT, ANY = 4, 8, 16, 32, 255
#: Masks of everything but one kind of event.
ONLY_REFLECTION, ONLY_TRANSMISSION = ANY & ~TRANSMISSION, ANY & ~REFLECTION


def surface(*closures: dict[str, Any], **geometry: Any) -> Surface:
    """Closures on a surface whose normals are +z unless `ng` or `ns` say otherwise."""
    return {"closures": list(closures), **geometry}


def closure(kind: str, **parameters: Any) -> dict[str, Any]:
    return {"kind": kind, **parameters}


TANGENT = (1.0, 0.3, 0.0)
#: One of every kind of smooth lobe, by name.
LOBES: dict[str, list[dict[str, Any]]] = {
    "lambert": [closure("diffuse")],
    "oren_nayar": [closure("diffuse", roughness=0.8, color=(0.9, 0.5, 0.2))],
    "translucent": [closure("translucent")],
    "ggx": [closure("glossy", distribution="GGX", roughness=0.6)],
    "ggx_rough": [closure("glossy", distribution="GGX", roughness=1.0)],
    "multi_ggx": [closure("glossy", distribution="MULTI_GGX", roughness=0.7)],
    "ggx_anisotropic": [
        closure("glossy", distribution="GGX", roughness=0.6, anisotropy=0.5, tangent=TANGENT)
    ],
    "beckmann": [closure("glossy", distribution="BECKMANN", roughness=0.7)],
    "beckmann_anisotropic": [
        closure("glossy", distribution="BECKMANN", roughness=0.6, anisotropy=-0.4, tangent=TANGENT)
    ],
    "ashikhmin_shirley": [closure("glossy", distribution="ASHIKHMIN_SHIRLEY", roughness=0.7)],
    "ashikhmin_shirley_anisotropic": [
        closure(
            "glossy",
            distribution="ASHIKHMIN_SHIRLEY",
            roughness=0.7,
            anisotropy=0.5,
            tangent=TANGENT,
        )
    ],
    "metallic": [closure("metallic", roughness=0.6)],
    "metallic_physical": [closure("metallic", roughness=0.6, physical=True)],
    "metallic_film": [closure("metallic", roughness=0.6, film=(400.0, 1.5))],
    "glass": [closure("glass", roughness=0.7)],
    "glass_beckmann": [closure("glass", roughness=0.7, distribution="BECKMANN", ior=1.8)],
    "glass_thinner": [closure("glass", roughness=0.7, ior=1 / 1.6)],
    "glass_film": [closure("glass", roughness=0.7, film=(350.0, 1.3))],
    "refraction": [closure("refraction", roughness=0.7)],
    "sheen": [closure("sheen", roughness=0.5)],
    "velvet": [closure("velvet", roughness=0.6)],
    "toon": [closure("toon", size=0.6, smooth=0.3)],
    "toon_glossy": [closure("toon", glossy=True, size=0.5, smooth=0.2)],
    "principled": [closure("principled", roughness=0.6)],
    "principled_layers": [
        closure(
            "principled",
            roughness=0.6,
            metallic=0.2,
            transmission_weight=0.4,
            coat_weight=0.6,
            coat_roughness=0.5,
            coat_tint=(0.9, 0.5, 0.2),
            sheen_weight=0.7,
            diffuse_roughness=0.5,
            anisotropic=0.5,
            tangent=TANGENT,
        )
    ],
    "principled_thin": [
        closure(
            "principled",
            thin_wall=True,
            roughness=0.7,
            transmission_weight=0.6,
            subsurface_weight=0.5,
            subsurface_anisotropy=0.3,
            diffuse_roughness=0.6,
        )
    ],
    "mix": [
        closure("glass", weight=(0.3, 0.3, 0.3), roughness=0.6),
        closure("diffuse", weight=(0.4, 0.2, 0.1)),
        closure("transparent", weight=(0.3, 0.2, 0.1)),
        closure("glossy", weight=(0.2, 0.2, 0.2), roughness=0.0),
    ],
}


def direction(cosine: float, azimuth: float = 0.4) -> Array:
    """The unit vector at a cosine with +z and an azimuth in radians, shape (1, 3)."""
    sine = np.sqrt(1 - cosine * cosine)
    return np.array([[sine * np.cos(azimuth), sine * np.sin(azimuth), cosine]])


def sphere(rng: np.random.Generator, count: int) -> Array:
    """Uniform directions, shape (count, 3)."""
    v = rng.normal(size=(count, 3))
    unit: Array = v / np.linalg.norm(v, axis=1, keepdims=True)
    return unit


def single(v: Array | Sequence[Sequence[float]]) -> NDArray[np.float32]:
    """What the probes take: contiguous float32."""
    return np.ascontiguousarray(v, np.float32)


class Values:
    """Columns of probe.bsdf_eval by name, in float64."""

    def __init__(self, s: Surface, wo: Array, wi: Array, **options: Any) -> None:
        t = np.asarray(probe.bsdf_eval(s, single(wo), single(wi), **options), np.float64)
        self.f, self.pdf, self.pdf_reverse = t[:, :3], t[:, 3], t[:, 4]


class Samples:
    """Columns of probe.bsdf_sample by name, in float64."""

    def __init__(self, s: Surface, wo: Array, u: Array, **options: Any) -> None:
        t = np.asarray(probe.bsdf_sample(s, single(wo), single(u), **options), np.float64)
        self.wi, self.weight, self.pdf, self.pdf_reverse = t[:, :3], t[:, 3:6], t[:, 6], t[:, 7]
        self.eta, self.lobe = t[:, 8], t[:, 9].astype(int)
        self.valid = self.lobe > 0
        self.singular = (self.lobe & SINGULAR) > 0
        self.smooth = self.valid & ~self.singular


def uniform(rng: np.random.Generator, count: int) -> Array:
    """Canonical random numbers for sampling, shape (count, 3), below 1 in float32."""
    return np.minimum(rng.random((count, 3)), 1 - 2.0**-24)
