"""Scene descriptions in files.

A file is an npz archive (zip) of two arrays of bytes. `header` is JSON in UTF-8: the dataclasses'
fields, with `{"array": [dtype, shape, offset]}` for an array and `{"link": [node, output]}` for a
link. `data` holds the arrays one after another. Nothing in a file is executed.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import os
import types
import typing
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from .description import Link, SceneDescription
from .validation import DescriptionError, validate

FORMAT = "vernier scene"
VERSION = 1


class StorageError(ValueError):
    """A file that holds no scene description; the message is one sentence for the user."""


def save(description: SceneDescription, path: str | os.PathLike[str]) -> None:
    """Writes a description, validated before, under a temporary name and then renamed.

    Raises DescriptionError, or OSError with nothing left behind.
    """
    validate(description)
    path = Path(path)
    writer = _Writer()
    tree = writer.encode(description)
    header = json.dumps({"format": FORMAT, "version": VERSION, "scene": tree}).encode()
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        with partial.open("wb") as file:
            np.savez_compressed(file, header=np.frombuffer(header, np.uint8), data=writer.data())
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def digest(description: SceneDescription) -> str:
    """A text that differs between scenes which differ in anything: 32 hexadecimal digits."""
    writer = _Writer()
    header = json.dumps(writer.encode(description), sort_keys=True).encode()
    state = hashlib.blake2b(header, digest_size=16)
    state.update(memoryview(np.ascontiguousarray(writer.data())).cast("B"))
    return state.hexdigest()


def load(path: str | os.PathLike[str]) -> SceneDescription:
    """Reads and validates a description. Raises StorageError, or OSError where there is no file."""
    path = Path(path)
    try:
        with np.load(path, allow_pickle=False) as archive:
            header = json.loads(archive["header"].tobytes().decode())
            _check_header(path, header)
            description = _Reader(archive["data"]).decode(SceneDescription, header["scene"])
        validate(description)
    except StorageError:
        raise
    except DescriptionError as error:
        raise StorageError(f"{path.name} holds a scene that breaks a rule: {error}") from error
    except FileNotFoundError:
        raise
    except Exception as error:  # numpy, zip and JSON raise what they like of damaged bytes
        what = " ".join(str(error).split())
        raise StorageError(f"{path.name} is damaged or no scene of Vernier's ({what})") from error
    return typing.cast(SceneDescription, description)


def _check_header(path: Path, header: Any) -> None:
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise StorageError(f"{path.name} is no scene of Vernier's")
    if header.get("version") != VERSION:
        raise StorageError(
            f"{path.name} has version {header.get('version')} of the scene format; "
            f"this program reads version {VERSION}"
        )


# Arrays start at multiples of this many bytes, as their elements' alignment asks.
_ALIGNMENT = 16
# The dtypes of the description's arrays.
_DTYPES = ("float32", "int32", "uint32", "uint8")


class _Writer:
    """Turns values into what JSON can hold; arrays are put aside."""

    def __init__(self) -> None:
        self._chunks: list[np.ndarray] = []
        self._size = 0

    def data(self) -> np.ndarray:
        """All arrays so far, as bytes."""
        return np.concatenate(self._chunks) if self._chunks else np.zeros(0, np.uint8)

    def encode(self, value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return {"array": [str(value.dtype), list(value.shape), self._put(value)]}
        if isinstance(value, Link):
            return {"link": [value.node, value.output]}
        if dataclasses.is_dataclass(value):
            fields = dataclasses.fields(value)
            return {field.name: self.encode(getattr(value, field.name)) for field in fields}
        if isinstance(value, dict):
            return {key: self.encode(item) for key, item in value.items()}
        if isinstance(value, list | tuple):
            return [self.encode(item) for item in value]
        if isinstance(value, Enum | np.integer):
            return int(typing.cast(int, value))
        return float(value) if isinstance(value, np.floating) else value

    def _put(self, array: np.ndarray) -> int:
        offset = self._size
        raw = np.frombuffer(np.ascontiguousarray(array).tobytes(), np.uint8)
        padding = np.zeros(-len(raw) % _ALIGNMENT, np.uint8)
        self._chunks += [raw, padding]
        self._size += len(raw) + len(padding)
        return offset


class _Reader:
    """Turns JSON back into values of the types that the fields declare."""

    def __init__(self, data: np.ndarray) -> None:
        self._data = data

    def decode(self, kind: Any, value: Any) -> Any:
        if isinstance(value, dict) and value.keys() == {"array"}:
            return self._array(*value["array"])
        if isinstance(value, dict) and value.keys() == {"link"}:
            node, output = value["link"]
            return Link(int(node), str(output))
        origin, arguments = typing.get_origin(kind), typing.get_args(kind)
        if dataclasses.is_dataclass(kind):
            return self._fields(typing.cast(type, kind), value)
        if origin in (typing.Union, types.UnionType):
            return self._union(arguments, value)
        if origin is list:
            return [self.decode(arguments[0], item) for item in _sequence(value)]
        if origin is tuple:
            return tuple(_sequence(value))
        if origin is dict:
            if not isinstance(value, dict):
                raise TypeError("a table is missing")
            return {str(key): self.decode(arguments[1], item) for key, item in value.items()}
        if isinstance(kind, type) and issubclass(kind, Enum):
            return kind(value)
        return value

    def _array(self, dtype: str, shape: list[int], offset: int) -> np.ndarray:
        if dtype not in _DTYPES or offset < 0 or any(size < 0 for size in shape):
            raise ValueError("an array is malformed")
        count = math.prod(shape)
        end = offset + count * np.dtype(dtype).itemsize
        if end > len(self._data):
            raise ValueError("an array reaches beyond the data")
        return self._data[offset:end].view(dtype).reshape(shape)

    def _fields(self, kind: type, value: Any) -> Any:
        hints = _hints(kind)
        if not isinstance(value, dict) or not value.keys() <= hints.keys():
            raise TypeError(f"a {kind.__name__} is malformed")
        return kind(**{name: self.decode(hints[name], item) for name, item in value.items()})

    def _union(self, arguments: tuple[Any, ...], value: Any) -> Any:
        """An optional dataclass, or numbers: a list is a tuple there."""
        if isinstance(value, dict):
            for argument in arguments:
                if dataclasses.is_dataclass(argument):
                    return self._fields(typing.cast(type, argument), value)
            raise TypeError("a value is malformed")
        return tuple(value) if isinstance(value, list) else value


@cache
def _hints(kind: type) -> dict[str, Any]:
    """The types of a dataclass's fields."""
    return typing.get_type_hints(kind)


def _sequence(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise TypeError("a list is missing")
    return value
