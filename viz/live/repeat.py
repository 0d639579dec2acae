"""Sending what seldom changes: axes, colour bars, the status."""

from typing import Generic, TypeVar

Value = TypeVar("Value")


class Repeated(Generic[Value]):
    """Says when to send a value: when it is another one, and all the same every `every_s` s of the run's time.

    A server forgets its oldest rows, so a viewer that comes late would not see what was sent once hours ago. What is
    sent for all times instead would change under the pictures of the past.
    """

    def __init__(self, every_s: float = 600.0) -> None:
        self._every_s = every_s
        self._sent: tuple[Value, float] | None = None

    def due(self, value: Value, time_s: float) -> bool:
        """Whether to send it now, at `time_s`; takes it as sent if so."""
        if self._sent is not None and self._sent[0] == value and 0 <= time_s - self._sent[1] < self._every_s:
            return False
        self._sent = value, time_s
        return True
