"""Writes engine_core/bsdf/sheen_coefficients.h: the microfibre sheen's parameters as polynomials.

Zeltner, Burley and Chiang (2022, "Practical Multiple-Scattering Sheen Using Linearly Transformed
Cosines") fitted a linear transform and an albedo to simulated layers of fibres, and published them
as a table over the cosine of the view and roughness. This script fits Chebyshev polynomials in the
square roots of both to that table, so that some two hundred numbers stand for three thousand.

The input is a text file of 3 x 32 x 32 numbers, separated by anything: the transform's entries a
and b, then the albedo; roughness by rows and the cosine by columns, both from 0 to 1.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

Array = NDArray[np.float64]

SIZE = 32
#: Rows of less roughness hold nearly no light, and noise.
FIRST_ROW = 2
NUMBER = re.compile(r"[-+]?\d*\.\d+(?:[eE][-+]?\d+)?")


def basis(count: int) -> Array:
    """Products of polynomials at the table's entries: (rows, columns, count * count)."""
    axis = np.linspace(0.0, 1.0, SIZE)
    values = chebyshev.chebvander(2.0 * np.sqrt(axis) - 1.0, count - 1)
    products = np.einsum("rl,ck->rclk", values[FIRST_ROW:], values)
    flat: Array = products.reshape(SIZE - FIRST_ROW, SIZE, count * count)
    return flat


def fit(table: Array, weight: Array, count: int) -> tuple[Array, float]:
    """Coefficients (roughness by rows), rounded, and the largest weighted error."""
    w = weight[FIRST_ROW:].reshape(-1, 1)
    a = basis(count).reshape(-1, count * count)
    t = table[FIRST_ROW:].reshape(-1, 1)
    solution = np.linalg.lstsq(a * w, t * w, rcond=1e-10)[0]
    rounded = np.round(solution, 5)
    return rounded.reshape(count, count), float(np.max(np.abs((a @ rounded - t) * w)))


def c_array(name: str, coefficients: Array) -> str:
    numbers = [f"{x:g}f" if x % 1 else f"{x:.1f}f" for x in coefficients.ravel()]
    lines, line = [], "   "
    for number in numbers:
        if len(line) + len(number) + 2 > 100:
            lines.append(line)
            line = "   "
        line += f" {number},"
    lines.append(line)
    head = f"inline constexpr int k{name}Terms = {len(coefficients)};\n"
    size = f"k{name}Terms * k{name}Terms"
    return head + f"inline constexpr float k{name}[{size}] = {{\n" + "\n".join(lines) + "\n};\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table", type=Path, help="the published table, as text")
    parser.add_argument("header", type=Path, help="the C++ header to write")
    arguments = parser.parse_args()
    numbers = [float(x) for x in NUMBER.findall(arguments.table.read_text())]
    if len(numbers) != 3 * SIZE * SIZE:
        parser.error(f"{arguments.table}: {len(numbers)} numbers instead of {3 * SIZE * SIZE}")
    a, b, albedo = np.array(numbers).reshape(3, SIZE, SIZE)
    # The transform matters in proportion to the light it shapes.
    weight = np.sqrt(np.maximum(albedo, 1e-4))
    parts = []
    for name, table, w, count in (
        ("SheenA", a, weight, 8),
        ("SheenB", b, weight, 8),
        ("SheenAlbedo", albedo, np.ones_like(albedo), 10),
    ):
        coefficients, error = fit(table, w, count)
        print(f"{name}: largest weighted error {error:.2g}")
        parts.append(c_array(name, coefficients))
    arguments.header.write_text(
        "// Written by scripts/fit_sheen.py: Chebyshev coefficients in the square roots of\n"
        "// roughness (rows) and of the cosine of the view (columns), both mapped to [-1, 1].\n"
        "#pragma once\n\nnamespace vernier {\n\n" + "\n".join(parts) + "\n}  // namespace vernier\n"
    )


if __name__ == "__main__":
    main()
