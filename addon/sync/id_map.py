"""Keeps what was made of a datablock until a depsgraph update marks that datablock."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

Value = TypeVar("Value")


class IdMap(Generic[Value]):
    """A cache in two phases, as Cycles' `id_map`: updates mark keys, then a pass asks for values.

    Keys are tuples whose members may be names or session identifiers of datablocks. Marking a
    session identifier drops every entry whose key contains it. What one pass did not ask for is
    dropped at its end.
    """

    def __init__(self) -> None:
        self._values: dict[Hashable, Value] = {}
        self._used: set[Hashable] = set()

    def mark(self, session_uids: set[int]) -> None:
        """Forgets what was made of the datablocks with these session identifiers."""
        if not session_uids:
            return
        for key in [k for k in self._values if isinstance(k, tuple) and session_uids & _uids(k)]:
            del self._values[key]

    def begin(self) -> None:
        """Starts a pass."""
        self._used.clear()

    def get(self, key: Hashable, make: Callable[[], Value]) -> Value:
        """Returns the value of `key`, made now if it is not there."""
        self._used.add(key)
        if key not in self._values:
            self._values[key] = make()
        return self._values[key]

    def end(self) -> None:
        """Ends a pass: what it did not use is dropped."""
        for key in self._values.keys() - self._used:
            del self._values[key]

    def clear(self) -> None:
        self._values.clear()
        self._used.clear()

    def __len__(self) -> int:
        return len(self._values)


def _uids(key: tuple[Hashable, ...]) -> set[int]:
    return {item for item in key if isinstance(item, int)}
