"""What a scene made the core model, what was left out, and what that saved: in words."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Modelled:
    """Short statements for panels and logs."""

    present: tuple[str, ...]
    left_out: tuple[str, ...]

    def lines(self) -> list[str]:
        return [
            f"Modelled: {'; '.join(self.present)}.",
            f"Left out: {'; '.join(self.left_out)}." if self.left_out else "Left out: nothing.",
        ]


#: By name of a requirement (engine_core/scene/requirements.h): what it is called where it is
#: modelled, and what its absence saves.
_FEATURES = {
    "programs": ("materials that vary over surfaces", "material programs: no material varies"),
    "light_tree": ("a light tree", "the light tree: there are not two lights to choose from"),
    "environment": ("light from the world", "the world: no map of it, no rays towards it"),
    "textured_emission": ("emission that varies over surfaces", ""),
    "transparent_shadows": (
        "surfaces that let light straight through",
        "light through surfaces: a shadow ray ends at the first",
    ),
    "singular_lobes": ("mirrors or clear glass", ""),
    "caustics": ("caustics", "caustics: no photons or paths are aimed for them"),
    "depth_of_field": ("depth of field", "the lens: all camera rays start at one point"),
    "instancing": ("instances", "instancing: one hierarchy without a second level"),
    "path_dependent": ("materials that read what a path has met", ""),
    "hidden_from_rays": ("objects that some rays do not see", "ray visibility: all rays see all"),
}


def plural(count: int, one: str, many: str = "") -> str:
    return f"{count:,} {one if count == 1 else many or one + 's'}"


def describe(
    requirements: Mapping[str, Any], channels_unused: int, pixels: int, passes: Collection[str]
) -> Modelled:
    """`requirements` as the compiled scene tells them; `channels_unused`: of the passes that nobody
    asked for; `passes`: the names of those asked for."""
    r = requirements
    triangles = plural(r["triangles"], "triangle")
    if r["instancing"]:
        triangles += f" ({r['instanced_triangles']:,} in {plural(r['instances'], 'instance')})"
    present = [triangles, plural(r["lamps"], "lamp")]
    if r["emissive_triangles"]:
        present.append(plural(r["emissive_triangles"], "glowing triangle"))
    materials = r["constant_materials"] + r["program_materials"]
    present.append(plural(materials, "material"))
    left_out = []
    for name, (what, saved) in _FEATURES.items():
        if r[name]:
            present.append(what)
        elif saved:
            left_out.append(saved)
    extra = [name for name in passes if name != "Combined"]
    if extra:
        present.append("the passes " + ", ".join(extra))
    if channels_unused:
        # Sums are float64.
        mib = channels_unused * 8 * pixels / 2**20
        left_out.append(f"passes that nobody asked for: {mib:.1f} MiB")
    return Modelled(tuple(present), tuple(left_out))
