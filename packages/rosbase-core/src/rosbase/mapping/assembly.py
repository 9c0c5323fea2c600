"""Puts the quantities of a payload together, and decides whether they make a sample."""

from collections.abc import Sequence
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

from attrs import frozen

from rosbase.mapping.rejects import Reject

__all__ = ["Batch", "Row", "Slot", "settle"]

SampleT = TypeVar("SampleT")

Row: TypeAlias = list[Any]
"""By slot the numbers, None or a `Reject`; behind them the date and what was left out."""


@frozen
class Batch(Generic[SampleT]):
    """The samples of one message, in the order of time."""

    samples: "Sequence[SampleT | Reject]"
    interval_ns: int | None = None
    """The time from one to the next in nanoseconds, if the mapping tells it."""


class Slot(NamedTuple):
    """A quantity, and where it stands in a row."""

    place: int
    name: str
    is_required: bool


def settle(row: Row, slots: Sequence[Slot], nothing: str) -> Reject | None:
    """Leave out of a row what cannot be used, or return why there is no sample.

    Args:
        row: Is changed: what is left out becomes None, and the reasons stand at the end.
        slots: The quantities of the mapping.
        nothing: The reason to give where the payload has nothing that the mapping knows.
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
