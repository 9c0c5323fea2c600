"""Ask the programs themselves whether they are ready, on their control sockets."""

from rosbase.clock import Clock
from rosbase.launcher.description import Condition

__all__ = ["ControlReadiness"]


class ControlReadiness:
    """Asks on the control sockets of a program's processes."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock

    def meets(self, pid: int, condition: Condition) -> bool:
        """Return whether a program meets the condition by now."""
        return False
