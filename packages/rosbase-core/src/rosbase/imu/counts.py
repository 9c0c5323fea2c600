"""What became of the frames: one number for each fate."""

from collections.abc import Mapping

from attrs import frozen

from rosbase.imu.rejects import IGNORED

__all__ = ["Counts", "CountsSnapshot"]


@frozen
class CountsSnapshot:
    """The counts at one moment. `received` = `published` + `rejected` + `ignored`."""

    published: int
    """Samples that went out."""
    by_reason: Mapping[str, int]
    """Frames that did not, by reason."""
    time_unusable: int
    """Samples that were stamped on arrival, because the device's time was no date."""

    @property
    def rejected(self) -> int:
        """Frames with a fault."""
        return sum(n for reason, n in self.by_reason.items() if reason not in IGNORED)

    @property
    def ignored(self) -> int:
        """Frames without a fault that are not for us."""
        return sum(n for reason, n in self.by_reason.items() if reason in IGNORED)

    @property
    def received(self) -> int:
        """All frames."""
        return self.published + self.rejected + self.ignored


class Counts:
    """Counts on the reader thread; any thread may take a snapshot."""

    __slots__ = ("by_reason", "published", "time_unusable")

    def __init__(self) -> None:
        self.published = 0
        self.time_unusable = 0
        self.by_reason: dict[str, int] = {}

    def add(self, reason: str, number: int = 1) -> None:
        """Counts frames that do not go out."""
        self.by_reason[reason] = self.by_reason.get(reason, 0) + number

    def snapshot(self, frame_errors: Mapping[str, int]) -> CountsSnapshot:
        """The counts now, together with what the transport could not frame."""
        total = Counts()
        total.by_reason = dict(self.by_reason)
        for reason, number in frame_errors.items():
            total.add(reason, number)
        return CountsSnapshot(self.published, total.by_reason, self.time_unusable)
