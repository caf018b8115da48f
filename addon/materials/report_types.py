"""The type of the function that takes messages to the user."""

from __future__ import annotations

from collections.abc import Callable

Warn = Callable[[str], None]
