"""A window of samples: two numbers describe its acceleration, for several checks."""

from math import hypot
from typing import NamedTuple

from rosbase.imu.mapping import Sample

__all__ = ["WINDOW", "Window", "summarise"]

WINDOW = 50
"""Number of samples in a window."""

# At rest, the norm of the acceleration varies by noise only: cheap sensors have a standard
# deviation below 0.1 m/s^2. Turning the sensor does not change the norm of gravity.
_STILL_RATIO = 0.04
_STILL_STDDEV = 0.15


class Window(NamedTuple):
    """Successive samples with an acceleration."""

    samples: list[Sample]
    norm: float
    """Mean norm of the acceleration, in m/s^2."""
    stddev: float
    """Standard deviation of the norm."""
    began_ns: int
    """End of the window before, in nanoseconds since the epoch."""
    ended_ns: int
    """Arrival of its last sample."""

    @property
    def is_still(self) -> bool:
        """Whether the acceleration varied by no more than noise."""
        return self.stddev <= max(_STILL_RATIO * self.norm, _STILL_STDDEV)


def summarise(samples: list[Sample], began_ns: int, ended_ns: int) -> Window:
    """Return the window of samples, each of which has an acceleration."""
    # One pass each in C: this is done for every sample, if not at every sample.
    norms = [hypot(*sample[2]) for sample in samples]  # type: ignore[misc]  # has one
    norm = sum(norms) / len(norms)
    variance = sum([one * one for one in norms]) / len(norms) - norm * norm
    return Window(samples, norm, max(0.0, variance) ** 0.5, began_ns, ended_ns)
