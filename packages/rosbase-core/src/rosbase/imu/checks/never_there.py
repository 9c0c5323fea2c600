"""Report once a quantity that the user has asked for and that no payload contains."""

from collections.abc import Iterable

from rosbase.imu.mapping import Sample

__all__ = ["NeverThere"]

# A device may need a moment until all its sensors have started.
_SAMPLES = 50


class NeverThere:
    """Watches whether the requested quantities come at all.

    Once each of them has come, or has been named, watching ends.
    """

    __slots__ = ("_missing", "_samples")

    def __init__(self, quantities: Iterable[str]) -> None:
        """Wait for the quantities, by name."""
        self._missing = list(quantities)
        self._samples = 0

    @property
    def is_waiting(self) -> bool:
        """Whether a quantity has not come yet."""
        return bool(self._missing)

    def add(self, sample: Sample) -> list[str]:
        """Take a published sample; return the quantities to name now."""
        self._missing = [name for name in self._missing if getattr(sample, name) is None]
        self._samples += 1
        if self._samples < _SAMPLES:
            return []
        named, self._missing = self._missing, []
        return named
