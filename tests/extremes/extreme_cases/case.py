"""What a case of the suite of extremes is: a scene, how it is rendered, and what it must show."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Flag, auto

from scenes import SceneBuilder

Build = Callable[[], SceneBuilder]


class Needs(Flag):
    """What a method must be able to find for the case to make sense for it."""

    NOTHING = 0
    #: Light after any number of matte surfaces.
    ALL_LIGHT = auto()
    #: What stands in a mirror, behind glass, or is polished itself.
    POLISHED = auto()
    #: Light of the sky and of suns that are disks, lamps with an extent.
    SOFT_LIGHT = auto()
    #: What few of the paths that start at lights meet: small parts of their way, large pictures.
    AIM = auto()
    #: Light that only paths from the camera know: it depends on who looks, or passes through walls.
    VIEW = auto()


@dataclass(frozen=True)
class Truth:
    """Every pixel is `value`, to `tolerance` (relative) and the picture's own error."""

    value: float
    tolerance: float = 1e-3


@dataclass(frozen=True)
class AtMost:
    """No pixel is above `value`, but for `tolerance` (relative) and the picture's own error."""

    value: float
    tolerance: float = 1e-3


@dataclass(frozen=True)
class Same:
    """The picture of another scene times `factor`, within both pictures' own errors.

    `slack`: a relative difference that the two scenes truly have. `of_paths`: the other picture is
    path tracing's whatever the method.
    """

    other: Build
    factor: float = 1.0
    slack: float = 0.0
    of_paths: bool = False


@dataclass(frozen=True)
class Dark:
    """Every pixel is exactly black."""


@dataclass(frozen=True)
class Finite:
    """Nothing but what every case must show."""


Expectation = Truth | AtMost | Same | Dark | Finite


@dataclass(frozen=True)
class Case:
    """Every case must also show: no NaN, infinity, negative radiance or dropped sample."""

    group: str
    name: str
    build: Build
    expects: Expectation
    needs: Needs = Needs.NOTHING
    settings: Mapping[str, object] = field(default_factory=dict)
    #: Samples per pixel of one of the independent pictures of the bounded run.
    samples: int = 8
    #: Whether the independent pictures are needed: without noise one is enough.
    noisy: bool = True
    #: Too large for the bounded run.
    large: bool = False
    #: Paths so long that the bounded run has them by path tracing alone.
    deep: bool = False
    #: Edges of light, or pixels so large, that what is merged is blurred by as much as is shown.
    blurred: bool = False
    #: Paths so long that methods leave them out whose time grows with the square of the length.
    not_joined: bool = False

    @property
    def title(self) -> str:
        return f"{self.group}: {self.name}"


def power_of_ten(value: float) -> str:
    """A short name of a number for titles."""
    return f"{value:g}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")
