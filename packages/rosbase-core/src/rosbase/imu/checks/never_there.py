"""A quantity that the user has asked for, and that no payload holds: said once."""

from collections.abc import Iterable

from rosbase.imu.mapping import Sample

__all__ = ["NeverThere"]

# A device may need a moment until all its sensors have started.
_SAMPLES = 50


class NeverThere:
    """Watches whether the quantities that were asked for come at all.

    Once each of them has been there, or has been named, nothing is watched any more.
    """

    __slots__ = ("_missing", "_samples")

    def __init__(self, quantities: Iterable[str]) -> None:
        """Wait for the quantities, by name."""
        self._missing = list(quantities)
        self._samples = 0

    @property
    def is_waiting(self) -> bool:
        """Whether there is one that has not come yet."""
        return bool(self._missing)

    def add(self, sample: Sample) -> list[str]:
        """Take a sample that goes out; return the quantities that are to be named now."""
        self._missing = [name for name in self._missing if getattr(sample, name) is None]
        self._samples += 1
        if self._samples < _SAMPLES:
            return []
        named, self._missing = self._missing, []
        return named
