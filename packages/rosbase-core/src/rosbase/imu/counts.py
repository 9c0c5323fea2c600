"""Counts of the frames: one number for each outcome.

Samples are counted: a frame with several samples counts each of them, with its own outcome. A
frame that cannot be read counts once, because its number of samples is not known. A sample without
one of its quantities is published and counts as such; the omission is counted separately.
"""

from collections.abc import Mapping

from attrs import field, frozen

from rosbase.imu.rejects import IGNORED

__all__ = ["Counts", "CountsSnapshot"]


@frozen
class CountsSnapshot:
    """Counts at one moment. `received` = `published` + `rejected` + `ignored`."""

    published: int
    """Number of samples published."""
    by_reason: Mapping[str, int]
    """Number of samples not published and of unreadable frames, by reason."""
    time_unusable: int
    """Number of samples stamped on arrival, because the device's time was no date."""
    left_out: Mapping[str, int] = field(factory=dict)
    """Number of unusable quantities that published samples left out, by reason."""
    clock_unusable: int = 0
    """Number of samples with a stamp of zero, because ROS cannot carry the date of this machine."""

    @property
    def rejected(self) -> int:
        """Number of samples and frames with a fault."""
        return sum(n for reason, n in self.by_reason.items() if reason not in IGNORED)

    @property
    def ignored(self) -> int:
        """Number of samples and frames without a fault that are not for us."""
        return sum(n for reason, n in self.by_reason.items() if reason in IGNORED)

    @property
    def received(self) -> int:
        """Total number of samples and frames."""
        return self.published + self.rejected + self.ignored


class Counts:
    """Counts on the reader thread; any thread may take a snapshot."""

    __slots__ = ("by_reason", "clock_unusable", "left_out", "published", "time_unusable")

    def __init__(self) -> None:
        self.published = 0
        self.time_unusable = 0
        self.clock_unusable = 0
        self.by_reason: dict[str, int] = {}
        self.left_out: dict[str, int] = {}

    def add(self, reason: str, number: int = 1) -> None:
        """Count frames that are not published."""
        self.by_reason[reason] = self.by_reason.get(reason, 0) + number

    def leave_out(self, reason: str) -> int:
        """Count a quantity that a sample leaves out; return the number so far."""
        self.left_out[reason] = self.left_out.get(reason, 0) + 1
        return self.left_out[reason]

    def snapshot(self, frame_errors: Mapping[str, int]) -> CountsSnapshot:
        """Return the counts now, including the data that the transport could not frame."""
        total = Counts()
        total.by_reason = dict(self.by_reason)
        for reason, number in frame_errors.items():
            total.add(reason, number)
        return CountsSnapshot(
            self.published,
            total.by_reason,
            self.time_unusable,
            dict(self.left_out),
            self.clock_unusable,
        )
