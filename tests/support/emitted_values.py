"""Values of shader nodes seen in pictures: a surface emits SCALE * value + OFFSET.

So negative values come through, and Cycles and Vernier are read in the same way.
"""

from __future__ import annotations

from typing import Any

import numpy as np

SCALE, OFFSET = 0.25, 4.0


def socket(sockets: Any, identifier: str) -> Any:
    """The socket of this identifier."""
    return next(s for s in sockets if s.identifier == identifier)


def emit(tree: Any, value: Any) -> None:
    """Makes the tree's material emit what comes out of the socket `value`."""
    encode = tree.nodes.new("ShaderNodeVectorMath")
    encode.operation = "MULTIPLY_ADD"
    encode.inputs[1].default_value = (SCALE,) * 3
    encode.inputs[2].default_value = (OFFSET,) * 3
    emission = tree.nodes.new("ShaderNodeEmission")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(value, encode.inputs[0])
    tree.links.new(encode.outputs[0], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])


def decoded(pixels: Any) -> Any:
    """The values that were emitted."""
    return (pixels - np.float32(OFFSET)) / np.float32(SCALE)
