"""How the error of photon methods falls: by passes, and by photons.

Renders a stored scene description again and again, beside a reference by path
tracing, fits the slope of the mean squared error over the work on logarithmic axes, and writes a
table and a figure. What is compared is indirect diffuse light at the pixels' middles: all that
photons tell there, and nothing else.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import engine_core
from engine_core import storage

Array = NDArray[np.float64]

#: The published rate of both: variance and squared bias fall alike (Kaplanyan, Dachsbacher 2013).
PUBLISHED = -2.0 / 3.0
_PASSES = (4, 16, 64, 256)
_PHOTONS = (1000, 4000, 16000, 64000)
_SEEDS = 3
_PASS = "Diffuse Indirect"
#: Nearest photons at the first number of photons; they grow with its power of 2/3.
_NEIGHBOURS = 12
_SIZE = (420, 300)
_COLOURS = ("#2a6fbb", "#c4541d")


def render(description: Any, **settings: Any) -> Array:
    """RGB of the indirect diffuse light."""
    scene = engine_core.compile(description)
    session = engine_core.Session(scene, settings, [_PASS])
    session.start()
    while not session.wait(10.0):
        pass
    picture = session.read(_PASS, 0, 0, scene.width, scene.height)
    return np.asarray(picture, np.float64)[..., :3]


def squared_error(description: Any, reference: Array, **settings: Any) -> float:
    """Mean over pixels and seeds."""
    shots = [render(description, seed=seed, **settings) for seed in range(_SEEDS)]
    return float(np.mean([(shot - reference) ** 2 for shot in shots]))


def progressive(description: Any, reference: Array) -> list[tuple[int, float]]:
    """Errors of progressive photon mapping by its number of passes."""
    return [
        (passes, squared_error(description, reference, integrator="SPPM", samples=passes))
        for passes in _PASSES
    ]


def maps(description: Any, reference: Array) -> list[tuple[int, float]]:
    """Errors of photon mapping by photons, with as many neighbours as the rate wants."""
    return [
        (
            photons,
            squared_error(
                description, reference, integrator="PHOTON", samples=1, global_photons=photons,
                caustic_photons=photons, photon_most_radius=1e6,
                photon_neighbours=round(_NEIGHBOURS * (photons / _PHOTONS[0]) ** (2 / 3)),
            ),
        )
        for photons in _PHOTONS
    ]  # fmt: skip


def slope(points: list[tuple[int, float]]) -> float:
    """Of the error over the work, both logarithmic."""
    work, error = np.log(np.array(points, np.float64)).T
    return float(np.polyfit(work, error, 1)[0])


def table(name: str, unit: str, points: list[tuple[int, float]]) -> str:
    """Markdown."""
    rows = "".join(f"| {work} | {error:.3g} |\n" for work, error in points)
    head = f"{name}: slope {slope(points):.2f}\n\n"
    return f"{head}| {unit} | Mean squared error |\n|---|---|\n{rows}"


def figure(curves: dict[str, list[tuple[int, float]]]) -> str:
    """An SVG: each curve over its work, relative to its first point, and the published slope."""
    width, height = _SIZE
    decades = 2.0  # of work; the error falls by fewer

    def place(work: float, error: float) -> tuple[float, float]:
        x = 40 + np.log10(work) / decades * (width - 60)
        return float(x), float(20 - np.log10(error) / decades * (height - 60))

    lines = []
    for number, (name, points) in enumerate(curves.items()):
        first = points[0]
        at = [place(work / first[0], error / first[1]) for work, error in points]
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
        colour = _COLOURS[number]
        lines.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
        label = f"{name}: {slope(points):.2f}"
        lines.append(f'<text x="60" y="{height - 60 + 18 * number}" fill="{colour}">{label}</text>')
    (x0, y0), (x1, y1) = place(1, 1), place(100, 100**PUBLISHED)
    lines.append(
        f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" stroke="#888" '
        'stroke-dasharray="4 4"/>'
    )
    lines.append(f'<text x="60" y="{height - 78}" fill="#888">published: {PUBLISHED:.2f}</text>')
    lines.append(f'<text x="{width / 2 - 60}" y="{height - 8}">passes, photons (log)</text>')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'font-family="sans-serif" font-size="12">'
        f'<rect width="{width}" height="{height}" fill="white"/>{"".join(lines)}</svg>\n'
    )


def main() -> None:
    """Measures one scene."""
    parser = argparse.ArgumentParser(prog="convergence", description=__doc__)
    parser.add_argument("scene", type=Path, help="a stored scene description")
    parser.add_argument("--width", type=int, default=64)
    parser.add_argument("--reference-samples", type=int, default=8192)
    parser.add_argument("-o", "--output", type=Path, help="where the figure goes, an SVG")
    options = parser.parse_args()
    description = storage.load(options.scene)
    film = description.film
    film.height = max(round(options.width * film.height / film.width), 1)
    film.width = options.width
    film.crop = (0, 0, film.width, film.height)
    film.filter_width = 0.01
    reference = render(
        description, integrator="PATH", samples=options.reference_samples, seed=1 << 20
    )
    by_passes, by_photons = progressive(description, reference), maps(description, reference)
    print(table("Progressive photon mapping", "Passes", by_passes))
    print(table("Photon mapping", "Photons", by_photons))
    if options.output:
        curves = {"progressive, by passes": by_passes, "two maps, by photons": by_photons}
        options.output.write_text(figure(curves), encoding="utf-8")


if __name__ == "__main__":
    main()
