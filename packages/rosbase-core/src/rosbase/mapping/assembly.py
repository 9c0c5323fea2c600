"""Combine the quantities of a payload into a sample, or give the reason to refuse it."""

from collections.abc import Sequence
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

from attrs import frozen

from rosbase.mapping.rejects import Reject

__all__ = ["Batch", "Row", "Slot", "settle"]

SampleT = TypeVar("SampleT")

Row: TypeAlias = list[Any]
"""The numbers, None or a `Reject` of each slot, then the date, then the left-out quantities."""


@frozen
class Batch(Generic[SampleT]):
    """The samples of one message, oldest first."""

    samples: "Sequence[SampleT | Reject]"
    interval_ns: int | None = None
    """The time between two samples in nanoseconds, if the mapping gives it."""


class Slot(NamedTuple):
    """The place of a quantity in a row."""

    place: int
    name: str
    is_required: bool


def settle(row: Row, slots: Sequence[Slot], nothing: str) -> Reject | None:
    """Remove unusable quantities from a row, or return the reason to refuse the sample.

    Args:
        row: Changed in place: an unusable quantity becomes None; its reason goes to the end.
        slots: The quantities of the mapping.
        nothing: The reason for a payload without any quantity of the mapping.
    """
    left_out: list[Reject] = []
    lacking = ""
    has_any = False
    for slot in slots:
        found = row[slot.place]
        if isinstance(found, Reject):
            if slot.is_required:
                return found
            left_out.append(found)
            row[slot.place] = None
        elif found is not None:
            has_any = True
        elif slot.is_required:
            lacking = lacking or slot.name
    row[-1] = tuple(left_out)
    if not has_any and not left_out:
        return Reject(nothing)
    if lacking:
        return Reject("missing_group", lacking)
    return None if has_any else left_out[0]
