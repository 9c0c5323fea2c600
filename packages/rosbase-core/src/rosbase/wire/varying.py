"""Fields of a message that vary, while everything else is prepared once.

A varying field is named by its path, such as `header.stamp` or `orientation`. Its value is, for a
time or a duration, the nanoseconds; for a message of numbers or an array, a sequence of its
numbers; and for a number, the number.
"""

from collections.abc import Sequence

from rosbase.messages.widths import TYPECODES, Width
from rosbase.wire.structure import Field, Kind, MessageType

__all__ = ["NS_PER_S", "TIMES", "arguments_of", "is_within", "kind_of"]

NS_PER_S = 1_000_000_000
TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
"""Messages whose value is a number of nanoseconds."""


def arguments_of(own: MessageType, varying: Sequence[str]) -> dict[str, str]:
    """Return the name of the argument of each varying field, by the path of the field.

    Raises:
        ValueError: A path leads to no numbers, or is named twice.
    """
    for number, path in enumerate(varying):
        kind = kind_of(own, path)
        clash = any(is_within(path, other) or is_within(other, path) for other in varying[:number])
        if kind is None or clash:
            reason = "is named twice" if clash else "has no fixed number of numbers"
            raise ValueError(f"{own.cls.__name__}.{path} cannot vary: it {reason}")
    return {path: f"value{number}" for number, path in enumerate(varying)}


def kind_of(own: MessageType, path: str) -> str | None:
    """Return the ROS type of a field that can vary; None if it cannot."""
    of: MessageType | Width = own
    one: Field | None = None
    for name in path.split("."):
        if not isinstance(of, MessageType):
            return None
        one = next((field for field in of.fields if field.name == name), None)
        if one is None or (one.kind is not Kind.ONE and isinstance(one.element, MessageType)):
            return None
        of = one.element
    if one is None or _leaf_count(one) is None:
        return None
    return of.name if isinstance(of, MessageType) else of.value


def is_within(path: str, other: str) -> bool:
    """Return whether a path is another one, or leads to a part of it."""
    return path == other or path.startswith(f"{other}.")


def _leaf_count(one: Field) -> int | None:
    """Return how many numbers a field has; None if that varies, or if it has texts."""
    if one.kind is Kind.SEQUENCE:
        return None
    if not isinstance(one.element, MessageType):
        count = 1 if one.kind is Kind.ONE else one.size
        return count if one.element in TYPECODES else None
    counts = [_leaf_count(field) for field in one.element.fields]
    if None in counts or not counts or one.kind is not Kind.ONE:
        return None
    return sum(count for count in counts if count is not None)
