"""Scene scale from 1e-6 to 1e6: the picture stays."""

from __future__ import annotations

from functools import partial

from bidirectional_scenes import apart, build, scaled
from scenes import SceneBuilder

from extreme_cases.case import Case, Needs, Same, Truth, power_of_ten
from extreme_cases.furnaces import after, furnace, unlimited

SCALES = [10.0**k for k in range(-6, 7) if k != 0]


def lit(scale: float, offset: float = 0.0) -> SceneBuilder:
    return scaled(apart("many", "focus_blades"), scale, offset)


def polished(material: str, scale: float) -> SceneBuilder:
    return scaled(build(material, "area"), scale)


def room(scale: float) -> SceneBuilder:
    return scaled(furnace(0.9, 0.1), scale)


def cases() -> list[Case]:
    found = []
    four = {"max_bounces": 4}
    for scale in SCALES:
        name = f"times {power_of_ten(scale)}"
        found.append(
            Case("scale", f"many lights {name}", partial(lit, scale), Same(partial(lit, 1.0)),
                 settings=four)
        )  # fmt: skip
        found.append(
            Case("scale", f"furnace {name}", partial(room, scale), Truth(after(5, 0.9, 0.1)),
                 Needs.ALL_LIGHT, unlimited(5), samples=4)
        )  # fmt: skip
        for material in ("glass", "mirror"):
            if abs(scale) in (1e-6, 1e-3, 1e3, 1e6):
                found.append(
                    Case("scale", f"{material} {name}", partial(polished, material, scale),
                         Same(partial(polished, material, 1.0)), settings=four)
                )  # fmt: skip
    return found
