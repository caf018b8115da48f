"""What sync has to tell the user."""

from __future__ import annotations


class Report:
    """A list of messages, each kept once, in the order in which they came."""

    def __init__(self) -> None:
        self._messages: dict[str, None] = {}

    def warn(self, message: str) -> None:
        """Records one sentence that names the datablock it is about."""
        self._messages.setdefault(message)

    @property
    def messages(self) -> list[str]:
        return list(self._messages)
