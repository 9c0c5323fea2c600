"""Detect other programs that read the same port, and tell them from an unplugged port."""

from imu_serial.holders import Process, holder_of
from imu_serial.refusals import shown

__all__ = ["Rivals"]

# How many looks pass before it is asked whether another reader is still there.
_LOOKS_BETWEEN = 5


class Rivals:
    """Other programs that read the same port, and so take a part of the data.

    They show as reads that return nothing although data was there, or as silence.
    """

    def __init__(self, path: str) -> None:
        self._path = path
        self._taken = 0
        self._was_quiet = False
        self._trouble = ""
        self._rival: Process | None = None
        self._looks = 0

    def note(self) -> None:
        """Count a read that returned nothing although data was there."""
        self._taken += 1

    def trouble(self, *, is_quiet: bool) -> str:
        """Return which programs read along, in a line; empty if none is known."""
        taken, self._taken = self._taken, 0
        begins_quiet, self._was_quiet = is_quiet and not self._was_quiet, is_quiet
        if self._trouble:
            self._look_again(taken)
        # Looking takes some milliseconds, so only for a reason.
        elif taken or begins_quiet:
            self._look(taken)
        return self._trouble

    def _look_again(self, taken: int) -> None:
        self._looks += 1
        if self._looks < _LOOKS_BETWEEN:
            return
        self._looks = 0
        rival = holder_of(self._path)
        if rival is not None:
            self._say(rival)
        elif self._rival is not None or not taken:
            # What it has taken before it went says nothing of anybody else.
            self._trouble, self._rival = "", None

    def _look(self, taken: int) -> None:
        rival = holder_of(self._path)
        # Once may be chance: of what was there a moment ago, a part may have been discarded.
        if rival is not None or taken > 1:
            self._say(rival)

    def _say(self, rival: Process | None) -> None:
        self._rival = rival
        who = rival or "a program that this user may not see"
        self._trouble = (
            f"{shown(self._path)} is read by {who} too: each byte reaches only one of the two"
            f"{rival.advice if rival else ''}"
        )
