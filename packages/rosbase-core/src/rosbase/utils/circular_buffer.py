"""A history of observations, such as a policy takes."""

import operator
import sys
from collections import deque
from typing import Any

from rosbase.utils.vectors import is_array

__all__ = ["CircularBuffer"]


class CircularBuffer:
    """Last values, oldest first.

    The first value after the start, or after `reset`, fills the whole buffer. All values have the
    shape of the first one. To append an array copies that array only.
    """

    def __init__(self, length: int) -> None:
        """Make an empty buffer.

        Args:
            length: Number of values; a buffer of length 0 swallows all values.

        Raises:
            ValueError: The length is negative.
        """
        self._length = operator.index(length)
        if self._length < 0:
            raise ValueError(f"a buffer has a length of 0 or more, not {length}")
        self._rows: _ArrayRows | deque[Any] | None = None
        self._shape: tuple[int, ...] = ()

    def __repr__(self) -> str:
        filled = "empty" if self._rows is None else f"shape {(self._length, *self._shape)}"
        return f"<CircularBuffer length={self._length} {filled}>"

    @property
    def buffer(self) -> Any:
        """Values, oldest first; an empty tuple before the first.

        If arrays of numpy are appended, it is one array with the shape of a value behind an axis of
        `length`. It is read-only, no copy, and later values do not change it. Otherwise it is a
        tuple of values; a list that was appended is a tuple in it.
        """
        if self._rows is None:
            return ()
        return self._rows.view() if isinstance(self._rows, _ArrayRows) else tuple(self._rows)

    def append(self, value: Any) -> None:
        """Append a value, in place of the oldest; the first one fills the buffer.

        Args:
            value: An array of numpy, a list or tuple of numbers, a number, or any other object.

        Raises:
            ValueError: It has another shape than the values before.
            TypeError: An array has a type that those before cannot hold, such as floats after
                integers.
        """
        shape = _shape_of(value)
        if self._rows is None:
            self._shape = shape
            if is_array(value):
                self._rows = _ArrayRows(value, self._length)
            else:
                first = _kept(value)
                self._rows = deque([first] * self._length, maxlen=self._length)
            return
        if shape != self._shape:
            raise ValueError(f"the values here have the shape {self._shape}, not {shape}")
        self._rows.append(value if isinstance(self._rows, _ArrayRows) else _kept(value))

    def reset(self) -> None:
        """Forget all values: the next one fills the buffer, and may have another shape."""
        self._rows = None


class _ArrayRows:
    """Rows of an array that is twice as long as the buffer.

    A row is written once. At the end of the array, a new one begins, with the rows that still
    count. So views of the old one stay as they are.
    """

    def __init__(self, first: Any, length: int) -> None:
        numpy: Any = sys.modules["numpy"]
        self._copy, self._new = numpy.copyto, numpy.empty_like
        self._length, self._end = length, length
        self._array = numpy.empty((2 * length, *first.shape), first.dtype)
        self._array[:length] = first

    def append(self, value: Any) -> None:
        if not self._length:
            return
        if self._end == len(self._array):
            before, self._array = self._array, self._new(self._array)
            kept = self._length - 1
            self._array[:kept] = before[self._end - kept :]
            self._end = kept
        self._copy(self._array[self._end, ...], value, casting="same_kind")
        self._end += 1

    def view(self) -> Any:
        view = self._array[self._end - self._length : self._end]
        view.flags.writeable = False
        return view


def _shape_of(value: Any) -> tuple[int, ...]:
    if isinstance(value, (list, tuple)):
        inner = {_shape_of(one) for one in value}
        if len(inner) > 1:
            raise ValueError(f"the parts of a value have different shapes: {sorted(inner)}")
        return (len(value), *(inner.pop() if inner else ()))
    # An array, of whatever library; a number and any other object have none.
    shape = getattr(value, "shape", ())
    return tuple(shape) if isinstance(shape, (tuple, list)) else ()


def _kept(value: Any) -> Any:
    """Return the value so that its owner cannot change it, as far as that is known."""
    if is_array(value):
        value = value.tolist()
    return tuple(map(_kept, value)) if isinstance(value, (list, tuple)) else value
