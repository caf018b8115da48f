"""What each method can find. One that is not named here is held to find everything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from extreme_cases.case import Case, Needs

import engine_core


@dataclass(frozen=True)
class Method:
    lacks: Needs = Needs.NOTHING
    #: Relative error that the method has by itself at a finite number of samples, and that which it
    #: has in cases that say so (`Case.blurred`).
    bias: float = 0.0
    blur: float = 0.0
    #: Other settings than a case's, so that a small picture costs little.
    settings: Mapping[str, object] = field(default_factory=dict)
    #: Of the cases, the bounded run has one in this many; by path tracing it has all.
    every: int = 6
    #: Joins every vertex to every other: long paths take the square of their length.
    joins: bool = False


METHODS = {
    "WHITTED": Method(Needs.ALL_LIGHT | Needs.SOFT_LIGHT),
    "LIGHT": Method(Needs.POLISHED | Needs.AIM | Needs.VIEW),
    "BDPT": Method(joins=True),
    # What it merges is blurred over the radius, of some pixels unless it is set; and pixels of a
    # case are as large as what is in it. Within one of them little is lost at edges.
    "VCM": Method(bias=0.02, blur=0.05, settings={"merge_radius": 1.0}, joins=True),
    "SPPM": Method(Needs.AIM | Needs.VIEW, bias=0.04, blur=0.15),
    "PHOTON": Method(
        Needs.AIM | Needs.VIEW,
        bias=0.15,
        blur=0.15,
        settings={
            "global_photons": 2000,
            "caustic_photons": 2000,
            "final_gather_rays": 2,
            "photon_neighbours": 20,
        },
        every=24,
    ),
}

INTEGRATORS = [
    identifier
    for parameter in engine_core.parameters()
    if parameter.name == "integrator"
    for identifier, *_ in parameter.items
]


def method(integrator: str) -> Method:
    return METHODS.get(integrator, Method())


def methods_of(case: Case) -> list[str]:
    """The methods for which the case makes sense."""
    return [
        name
        for name in INTEGRATORS
        if not case.needs & method(name).lacks and not (case.not_joined and method(name).joins)
    ]


def bounded_methods_of(case: Case, number: int) -> list[str]:
    """Those of them that have case number `number` in the bounded run: all have their turn."""
    if case.large:
        return []
    return [
        name
        for name in methods_of(case)
        if name == "PATH"
        or (not case.deep and (number + INTEGRATORS.index(name)) % method(name).every == 0)
    ]
