"""A low-pass filter for vectors, such as velocities for a policy."""

import math
import operator
from typing import Any

from rosbase.utils.vectors import floats_of, is_array, maths_for

__all__ = ["VectorLPFilter"]


class VectorLPFilter:
    """First-order low pass of each number of a vector. The first vector passes through.

    The discretisation is exact for a signal that is constant between two updates: after a step, the
    output is `1 - exp(-2 pi f t)` at the time t, whatever the period.
    """

    def __init__(self, sample_period: float, cutoff_freq: float, num_channels: int = 3) -> None:
        """Make a filter without a value.

        Args:
            sample_period: Seconds between two updates.
            cutoff_freq: Hertz, at which the output has 0.71 of the amplitude of the input.
            num_channels: Numbers of a vector.

        Raises:
            ValueError: One of them is not positive, or not finite.
        """
        self._rate = 2.0 * math.pi * _positive(cutoff_freq, "cutoff_freq")
        self._share = self._share_in(sample_period)
        self._channels = operator.index(num_channels)
        if self._channels < 1:
            raise ValueError(f"num_channels is 1 or more, not {num_channels}")
        self._values: Any = None

    def __repr__(self) -> str:
        return f"<VectorLPFilter {self.get_values()}>"

    def update(self, vector: Any, sample_period: float | None = None) -> None:
        """Take the next vector.

        Args:
            vector: A list, a tuple, an array of numpy, or for three channels a message such as
                `Vector3`.
            sample_period: Seconds since the last update; by default as given to the constructor.

        Raises:
            ValueError: The vector has another number of numbers, or one is not finite, which the
                filter could never forget; or the period is not positive.
            TypeError: The vector is a text, or has complex numbers.
        """
        new = self._read(vector)
        share = self._share if sample_period is None else self._share_in(sample_period)
        old = self._values
        if old is None:
            self._values = new
        elif is_array(old) or is_array(new):
            self._values = old + share * (new - old)
        else:
            self._values = tuple(o + share * (n - o) for o, n in zip(old, new, strict=True))

    def get_values(self) -> Any:
        """Return the filtered vector; zeros before the first update.

        It is an array of numpy if arrays are given, and a tuple otherwise. The array is a copy,
        which may be changed.
        """
        if self._values is None:
            return (0.0,) * self._channels
        return self._values.copy() if is_array(self._values) else self._values

    def _share_in(self, period: float) -> float:
        return -math.expm1(-self._rate * _positive(period, "sample_period"))

    def _read(self, vector: Any) -> Any:
        if is_array(vector):
            new, shape = floats_of(vector), vector.shape
        else:
            if self._channels == 3 and all(hasattr(vector, name) for name in "xyz"):
                vector = (vector.x, vector.y, vector.z)
            new = floats_of(vector)
            shape = (len(new),)
        if shape != (self._channels,):
            raise ValueError(f"takes vectors of {self._channels} numbers, not of the shape {shape}")
        are_finite = maths_for(new).are_finite
        if not (are_finite(new) if is_array(new) else all(map(are_finite, new))):
            raise ValueError(f"takes finite numbers, not {vector}")
        return new


def _positive(value: float, name: str) -> float:
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name} is a positive number, not {value}")
    return float(value)
