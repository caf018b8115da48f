"""Every method shows path tracing's picture: energy is the same both ways, and nothing is lost."""

from __future__ import annotations

from functools import partial

from bidirectional_scenes import CAMERAS, LIGHTS, MATERIALS, NOT_EMITTED, build

from extreme_cases.case import Case, Needs, Same

#: Seen in a mirror, or through glass.
POLISHED = {"mirror", "glass", "near_mirror", "facing_mirrors", "principled_glass",
            "fresnel_mirror", "diffuse_and_mirror", "principled_coat", "refraction"}  # fmt: skip

#: Within its own sphere a lamp lights things to paths from the camera alone.
VIEWED = NOT_EMITTED | {"point_hard_near"}


def cases() -> list[Case]:
    found = []
    four: dict[str, object] = {"max_bounces": 4}
    plain = Needs.ALL_LIGHT | Needs.SOFT_LIGHT
    for material in MATERIALS:
        scene = partial(build, material, "area")
        needs = plain | Needs.POLISHED if material in POLISHED else plain
        viewed = material.startswith("light_path") or material == "backfacing"
        needs |= Needs.VIEW if viewed else Needs.NOTHING
        found.append(
            Case("agreement", f"material {material}", scene, Same(scene, of_paths=True), needs,
                 four, samples=16)
        )  # fmt: skip
    for light in LIGHTS:
        scene = partial(build, "diffuse", light)
        found.append(
            Case("agreement", f"light {light}", scene, Same(scene, of_paths=True),
                 plain | Needs.VIEW if light in VIEWED else plain, four, samples=16,
                 blurred=True)
        )  # fmt: skip
    for view in CAMERAS:
        scene = partial(build, "diffuse", "area", view)
        found.append(
            Case("agreement", f"camera {view}", scene, Same(scene, of_paths=True), plain, four,
                 samples=16)
        )  # fmt: skip
    return found
