"""Mitsuba's pictures of the scenes of `tests/agreement/test_mitsuba.py`.

Run as a program in a process of its own: `python mitsuba_renders.py RESULT.npz NAME...`, where NAME
is MATERIAL-LIGHT. Mitsuba's scalar_rgb needs nothing else, but does not live well beside Blender.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

SIZE, SAMPLES, SEEDS = 24, 160, 4
RADIUS, RINGS = 1.0, 96
GREY = (0.7, 0.5, 0.3)
# Real conductor indices (gold-like) and the dielectric's.
ETA, KAPPA, IOR = (0.2, 0.6, 1.4), (3.2, 2.4, 1.9), 1.5
LAMP_RADIANCE, LAMP_SIZE, LAMP_HEIGHT = 5.0, 4.0, 2.3
SKY_ROWS, SKY_COLUMNS = 128, 256

MATERIALS = {
    "diffuse": (),
    "conductor_smooth": (0.0,),
    "conductor_rough": (0.3,),
    "conductor_rougher": (0.6,),
    "dielectric_smooth": (0.0,),
    "dielectric_rough": (0.3,),
}
LIGHTS = ("area", "sky")


def sky() -> Any:
    """An environment with z up and a soft sun: (rows from the zenith down, columns, 3), linear.

    It is smooth, because renderers differ by half a pixel in where they place rows and columns.
    """
    v, u = np.mgrid[0:SKY_ROWS, 0:SKY_COLUMNS] + 0.5
    theta, phi = np.pi * v / SKY_ROWS, 2 * np.pi * u / SKY_COLUMNS
    d = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    base = np.stack([0.6 + 0.3 * d[..., 0], 0.6 + 0.3 * d[..., 1], 0.7 + 0.5 * d[..., 2]], axis=-1)
    sun = np.exp(25.0 * (d @ np.array([0.48, 0.6, 0.64]) - 1.0))
    return (base + sun[..., None] * np.array([20.0, 16.0, 10.0])).astype(np.float32)


def _material(name: str) -> dict[str, Any]:
    kind, _, _ = name.partition("_")
    if kind == "diffuse":
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(GREY)}}
    alpha = MATERIALS[name][0] ** 2
    rough = {"alpha": alpha, "distribution": "ggx"} if alpha > 0.0 else {}
    prefix = "rough" if alpha > 0.0 else ""
    if kind == "conductor":
        indices = {
            "eta": {"type": "rgb", "value": list(ETA)},
            "k": {"type": "rgb", "value": list(KAPPA)},
        }
        return {"type": f"{prefix}conductor", **indices, **rough}
    return {"type": f"{prefix}dielectric", "int_ior": IOR, "ext_ior": 1.0, **rough}


def _light(mi: Any, kind: str) -> dict[str, Any]:
    transform = mi.ScalarTransform4f
    if kind == "area":
        place = transform().translate([0, 0, LAMP_HEIGHT]).rotate([1, 0, 0], 180)
        return {
            "type": "rectangle",
            "to_world": place.scale([LAMP_SIZE / 2, LAMP_SIZE / 2, 1]),
            "emitter": {
                "type": "area",
                "radiance": {"type": "rgb", "value": [LAMP_RADIANCE] * 3},
            },
        }
    # Mitsuba's map has y up: turned so that its pole is z.
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(sky()),
        "to_world": transform().rotate([1, 0, 0], 90),
    }


def main() -> None:
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    arrays = {}
    for name in sys.argv[2:]:
        material, kind = name.rsplit("-", 1)
        scene = mi.load_dict(
            {
                "type": "scene",
                "integrator": {"type": "path", "max_depth": -1, "rr_depth": 1000},
                "sensor": {
                    "type": "perspective",
                    "fov": 30.0,
                    "to_world": mi.ScalarTransform4f().look_at(
                        origin=[0, -6, 3], target=[0, 0, 0], up=[0, 0, 1]
                    ),
                    "film": {
                        "type": "hdrfilm",
                        "width": SIZE,
                        "height": SIZE,
                        "rfilter": {"type": "box"},
                        "pixel_format": "rgb",
                        "component_format": "float32",
                    },
                    "sampler": {"type": "independent", "sample_count": SAMPLES},
                },
                "ball": {"type": "sphere", "radius": RADIUS, "bsdf": _material(material)},
                "light": _light(mi, kind),
            }
        )
        arrays[name] = np.stack(
            [np.array(mi.render(scene, seed=seed, spp=SAMPLES)) for seed in range(SEEDS)]
        )
    np.savez(sys.argv[1], **arrays)


if __name__ == "__main__":
    main()
