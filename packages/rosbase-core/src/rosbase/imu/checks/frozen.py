"""Check for changes: a live sensor has noise, and one that repeats itself is stuck."""

from collections.abc import Mapping
from typing import ClassVar

from rosbase.imu.mapping import Sample

__all__ = ["Frozen"]

_FEWEST = 20
# A run that ended by itself was no freeze: the next must be that much longer.
_MARGIN = 4.0
# But whoever has once hung for long may hang again.
_LONGEST_S = 10.0
# Noise shows if the last digit is at most this, in m/s^2 and rad/s. Where numbers are rounded to
# more, a sensor at rest repeats itself for minutes.
_FINE = {"linear_acceleration": 0.012, "angular_velocity": 0.0012}
_MOST_DIGITS = 9


class Frozen:
    """Detects runs in which no quantity changes, to the last digit.

    A quantity in separate samples, or one that is measured less often, counts as unchanged
    until it changes. A run needs all quantities to stand still.
    """

    reason: ClassVar[str] = "frozen"

    __slots__ = (
        "_after_ns",
        "_factors",
        "_field",
        "_needed_ns",
        "_orientation",
        "_rate",
        "_since_ns",
        "acceleration",
        "finding",
        "repeats",
    )

    def __init__(self, after_s: float, factors: Mapping[str, float]) -> None:
        """Start with the next sample.

        Args:
            after_s: Seconds after which a run of equal samples is a finding.
            factors: Factors by which the numbers of a payload were multiplied, by quantity. Noise
                shows only in numbers with enough digits.
        """
        self.finding = ""
        """Finding that the samples repeat, in one line; empty if they do not."""
        self._factors = factors
        self._after_ns = self._needed_ns = round(after_s * 1e9)
        self.acceleration: tuple[float, ...] | None = None
        """Last acceleration.

        Code that finds another one in a sample may set it while there are no repeats, and
        need not add the sample.
        """
        self.repeats = 0
        """Number of samples in a row without a change."""
        self._rate: tuple[float, ...] | None = None
        self._orientation: tuple[float, ...] | None = None
        self._field: tuple[float, ...] | None = None
        self._since_ns = 0

    def add(self, sample: Sample, arrived_ns: int) -> None:
        """Compare a sample with the ones before it."""
        acceleration = sample[2]
        # The usual case ends here.
        if acceleration != self.acceleration and acceleration is not None:
            self.acceleration = acceleration
            if self.repeats:
                self._end(arrived_ns)
        elif self._others_change(sample):
            self._end(arrived_ns)
        else:
            self._repeat(arrived_ns)

    def _others_change(self, sample: Sample) -> bool:
        orientation, rate, field = sample[0], sample[1], sample[3]
        if rate is not None and rate != self._rate:
            self._rate = rate
        elif orientation is not None and orientation != self._orientation:
            self._orientation = orientation
        elif field is not None and field != self._field:
            self._field = field
        else:
            return False
        return True

    def _repeat(self, arrived_ns: int) -> None:
        if not self.repeats or arrived_ns < self._since_ns:
            # The first, or the clock was set back meanwhile.
            self._since_ns = arrived_ns
        self.repeats += 1
        if self.finding or self.repeats < _FEWEST:
            return
        lasts_ns = arrived_ns - self._since_ns
        if lasts_ns >= self._needed_ns and self._would_show_noise():
            self.finding = (
                f"all numbers are the same, to the last digit, for {lasts_ns / 1e9:.1f} s:"
                " does the sensor hang?"
            )

    def _end(self, arrived_ns: int) -> None:
        lasted_ns = arrived_ns - self._since_ns
        if self.repeats >= _FEWEST and lasted_ns > 0:
            needed_ns = min(_MARGIN * lasted_ns, _LONGEST_S * 1e9)
            self._needed_ns = max(self._needed_ns, round(needed_ns))
        self.finding = ""
        self.repeats = 0

    def _would_show_noise(self) -> bool:
        found = {"linear_acceleration": self.acceleration, "angular_velocity": self._rate}
        return any(
            _last_digit(numbers, self._factors.get(name, 1.0)) <= _FINE[name]
            for name, numbers in found.items()
            if numbers is not None
        )


def _last_digit(numbers: tuple[float, ...], factor: float) -> float:
    """Return the place of the last digit in a payload's numbers, in the SI unit."""
    for digits in range(_MOST_DIGITS):
        raw = [number / factor for number in numbers]
        if all(abs(round(n, digits) - n) <= 1e-12 * max(1.0, abs(n)) for n in raw):
            return float(abs(factor) * 10.0**-digits)
    return 0.0
