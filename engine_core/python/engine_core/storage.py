"""Scene descriptions in files.

A file is an npz archive (zip) of numpy arrays and one array `header` of bytes: JSON in UTF-8 that
holds everything else, with `{"array": NAME}` where an array stands and `{"link": [node, output]}`
where a link does. Nothing in a file is executed.
"""

from __future__ import annotations

import dataclasses
import json
import os
import types
import typing
import zipfile
from enum import Enum
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
    arrays: dict[str, np.ndarray] = {}
    tree = _encode(description, arrays)
    header = json.dumps({"format": FORMAT, "version": VERSION, "scene": tree}).encode()
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        with partial.open("wb") as file:
            np.savez_compressed(file, header=np.frombuffer(header, np.uint8), **arrays)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def load(path: str | os.PathLike[str]) -> SceneDescription:
    """Reads and validates a description. Raises StorageError, or OSError where there is no file."""
    path = Path(path)
    try:
        with np.load(path, allow_pickle=False) as archive:
            header = json.loads(archive["header"].tobytes().decode())
            _check_header(path, header)
            arrays = {name: archive[name] for name in archive.files if name != "header"}
        description = _decode(SceneDescription, header["scene"], arrays)
        validate(description)
    except StorageError:
        raise
    except DescriptionError as error:
        raise StorageError(f"{path.name} holds a scene that breaks a rule: {error}") from error
    except FileNotFoundError:
        raise
    except (zipfile.BadZipFile, EOFError, OSError, ValueError, KeyError, TypeError) as error:
        raise StorageError(
            f"{path.name} is damaged or no scene of Vernier's ({error})"
        ) from error
    return typing.cast(SceneDescription, description)


def _check_header(path: Path, header: Any) -> None:
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise StorageError(f"{path.name} is no scene of Vernier's")
    if header.get("version") != VERSION:
        raise StorageError(
            f"{path.name} has version {header.get('version')} of the scene format; "
            f"this program reads version {VERSION}"
        )


def _encode(value: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Turns a value into what JSON can hold; arrays are put aside."""
    if isinstance(value, np.ndarray):
        name = f"a{len(arrays)}"
        arrays[name] = value
        return {"array": name}
    if isinstance(value, Link):
        return {"link": [value.node, value.output]}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = dataclasses.fields(value)
        return {field.name: _encode(getattr(value, field.name), arrays) for field in fields}
    if isinstance(value, dict):
        return {key: _encode(item, arrays) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_encode(item, arrays) for item in value]
    if isinstance(value, Enum | np.integer):
        return int(typing.cast(int, value))
    if isinstance(value, np.floating):
        return float(value)
    return value


def _decode(kind: Any, value: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Turns JSON back into a value of the type that a field declares."""
    if isinstance(value, dict) and value.keys() == {"array"}:
        return arrays[value["array"]]
    if isinstance(value, dict) and value.keys() == {"link"}:
        node, output = value["link"]
        return Link(int(node), str(output))
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if dataclasses.is_dataclass(kind):
        return _decode_fields(typing.cast(type, kind), value, arrays)
    if origin in (typing.Union, types.UnionType):
        return _decode_union(arguments, value, arrays)
    if origin is list:
        return [_decode(arguments[0], item, arrays) for item in _sequence(value)]
    if origin is tuple:
        return tuple(_sequence(value))
    if origin is dict:
        if not isinstance(value, dict):
            raise TypeError("a table is missing")
        return {str(key): _decode(arguments[1], item, arrays) for key, item in value.items()}
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind(value)
    return value


def _decode_fields(kind: type, value: Any, arrays: dict[str, np.ndarray]) -> Any:
    hints = typing.get_type_hints(kind)
    names = {field.name for field in dataclasses.fields(kind)}
    if not isinstance(value, dict) or not value.keys() <= names:
        raise TypeError(f"a {kind.__name__} is malformed")
    return kind(**{name: _decode(hints[name], item, arrays) for name, item in value.items()})


def _decode_union(arguments: tuple[Any, ...], value: Any, arrays: dict[str, np.ndarray]) -> Any:
    """An optional dataclass, or numbers: a list is a tuple there."""
    if isinstance(value, dict):
        for argument in arguments:
            if dataclasses.is_dataclass(argument):
                return _decode_fields(typing.cast(type, argument), value, arrays)
        raise TypeError("a value is malformed")
    return tuple(value) if isinstance(value, list) else value


def _sequence(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise TypeError("a list is missing")
    return value
