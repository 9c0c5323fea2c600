"""What became of the frames: one number for each fate.

Samples are counted: a frame that holds several counts as often, each with its own fate. A frame
that cannot be read counts once, for nobody knows how many samples it held. A sample from which
a quantity was left out is published and counts as such; what was left out is counted beside it.
"""

from collections.abc import Mapping

from attrs import field, frozen

from rosbase.imu.rejects import IGNORED

__all__ = ["Counts", "CountsSnapshot"]


@frozen
class CountsSnapshot:
    """The counts at one moment. `received` = `published` + `rejected` + `ignored`."""

    published: int
    """Samples that went out."""
    by_reason: Mapping[str, int]
    """Samples, and frames that could not be read, that did not, by reason."""
    time_unusable: int
    """Samples that were stamped on arrival, because the device's time was no date."""
    left_out: Mapping[str, int] = field(factory=dict)
    """Quantities that published samples go without because they could not be used, by reason."""
    clock_unusable: int = 0
    """Samples with a stamp of zero, because ROS cannot carry the date of this machine."""

    @property
    def rejected(self) -> int:
        """Those with a fault."""
        return sum(n for reason, n in self.by_reason.items() if reason not in IGNORED)

    @property
    def ignored(self) -> int:
        """Those without a fault that are not for us."""
        return sum(n for reason, n in self.by_reason.items() if reason in IGNORED)

    @property
    def received(self) -> int:
        """All of them."""
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
        """Counts frames that do not go out."""
        self.by_reason[reason] = self.by_reason.get(reason, 0) + number

    def leave_out(self, reason: str) -> int:
        """Count a quantity that a sample goes without; return how many there are by now."""
        self.left_out[reason] = self.left_out.get(reason, 0) + 1
        return self.left_out[reason]

    def snapshot(self, frame_errors: Mapping[str, int]) -> CountsSnapshot:
        """The counts now, together with what the transport could not frame."""
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
