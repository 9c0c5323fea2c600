"""Marks in the annotations of fields: sizes, and buffers of numbers. `widths` has the types."""

from attrs import frozen

from rosbase.messages.widths import Width

__all__ = ["AtMost", "Fixed", "Numbers"]


@frozen
class _Size:
    """A number of elements."""

    size: int


# Subclasses, because each class of attrs costs a third of a millisecond at the start.
class Fixed(_Size):
    """An array of that many elements; in the annotation of a tuple or a buffer."""

    __slots__ = ()


class AtMost(_Size):
    """A sequence or a text of at most that many elements or bytes."""

    __slots__ = ()


@frozen
class Numbers:
    """A buffer of numbers of that width."""

    width: Width
