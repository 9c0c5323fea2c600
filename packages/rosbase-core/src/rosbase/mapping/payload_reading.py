"""Readers of whole frames: from bytes to a sample, to several, or to a reason."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias, TypeVar

from rosbase.mapping.assembly import Batch, Row, Slot, settle
from rosbase.mapping.batches import BatchReader
from rosbase.mapping.conditions import Predicate
from rosbase.mapping.decoding import decode_payload
from rosbase.mapping.intervals import IntervalReader
from rosbase.mapping.quick_dates import compile_date
from rosbase.mapping.quick_reading import Reader
from rosbase.mapping.rejects import Reject
from rosbase.mapping.times import Date, Dates

__all__ = ["FrameReader", "Plan", "batch_reader", "single_reader"]

SampleT = TypeVar("SampleT")

FrameReader: TypeAlias = Callable[[bytes], SampleT | Reject | Batch[SampleT]]
"""Function from a frame to a sample, to several, or to a reason. Never raises."""

_NOT_SELECTED = Reject("not_selected")


class Plan(NamedTuple):
    """The parts of a mapping that readers of frames need beside the quantities."""

    conditions: tuple[Predicate, ...]
    slots: tuple[Slot, ...]
    size: int
    """The number of quantities in a row, with and without paths."""
    nothing: str
    """The reason for payloads without any quantity of the mapping."""
    dates: Dates | None
    interval: IntervalReader | None

    def payload(self, frame: bytes) -> object:
        """Return the payload in a frame, or the reason to refuse or ignore it."""
        payload = decode_payload(frame)
        if isinstance(payload, Reject) or all(holds(payload) for holds in self.conditions):
            return payload
        return _NOT_SELECTED


def single_reader(
    plan: Plan, readers: Sequence[Reader], make: Callable[[Row], SampleT]
) -> Callable[[bytes], SampleT | Reject]:
    """Return a reader of frames with one sample each.

    Args:
        plan: The parts of the mapping beside the quantities.
        readers: By slot.
        make: Makes a sample of a row.
    """
    conditions, slots, nothing = plan.conditions, plan.slots, plan.nothing
    steps = [
        (slot.place, read, slot.is_required) for slot, read in zip(slots, readers, strict=True)
    ]
    blank: Row = [*[None] * plan.size, None, ()]
    read_date = compile_date(plan.dates) if plan.dates else None

    def read_frame(frame: bytes) -> SampleT | Reject:
        payload = decode_payload(frame)
        if payload.__class__ is Reject:
            return payload
        for holds in conditions:
            if not holds(payload):
                return _NOT_SELECTED
        row = blank[:]
        has_any = is_odd = False
        for index, read, is_required in steps:
            numbers = read(payload)
            if numbers.__class__ is tuple:
                row[index] = numbers
                has_any = True
            elif is_required or numbers is not None:
                row[index] = numbers
                is_odd = True
        if is_odd or not has_any:
            reject = settle(row, slots, nothing)
            if reject is not None:
                return reject
        if read_date is not None:
            _add_date(row, read_date(payload))
        return make(row)

    return read_frame


def batch_reader(
    plan: Plan, readers: Sequence[BatchReader], make: Callable[[Row], SampleT]
) -> FrameReader[SampleT]:
    """Return a reader of frames with several samples each. See `single_reader`."""
    slots = plan.slots

    def read_frame(frame: bytes) -> SampleT | Reject | Batch[SampleT]:
        payload = plan.payload(frame)
        if isinstance(payload, Reject):
            return payload
        found = [read(payload) for read in readers]
        count = _agreed_count(slots, found)
        if isinstance(count, Reject):
            return count
        rows = [_row(plan, found, at, count) for at in range(count or 1)]
        rejects = [settle(row, slots, plan.nothing) for row in rows]
        if not count:
            return rejects[0] or Reject(plan.nothing)
        interval_ns = plan.interval(payload) if plan.interval else None
        if plan.dates is not None:
            dates = plan.dates.dates(payload, count, interval_ns)
            for row, date in zip(rows, dates, strict=True):
                _add_date(row, date)
        samples = [reject or make(row) for row, reject in zip(rows, rejects, strict=True)]
        return Batch(samples, interval_ns)

    return read_frame


def _agreed_count(slots: Sequence[Slot], found: Sequence[object]) -> int | Reject:
    """Return the number of samples in a message, by the required quantities if there are any."""
    counts = {
        slot: len(numbers)
        for slot, numbers in zip(slots, found, strict=True)
        if isinstance(numbers, list)
    }
    deciding = {slot: n for slot, n in counts.items() if slot.is_required} or counts
    if len(set(deciding.values())) > 1:
        said = ", ".join(f"{n} of {slot.name}" for slot, n in deciding.items())
        return Reject("uneven", said)
    return max(deciding.values(), default=0)


def _row(plan: Plan, found: Sequence[Any], at: int, count: int) -> Row:
    """Return the row of one sample, before `settle`."""
    row: Row = [*[None] * plan.size, None, ()]
    for slot, numbers in zip(plan.slots, found, strict=True):
        if not isinstance(numbers, list):
            row[slot.place] = numbers
        elif len(numbers) == count:
            row[slot.place] = numbers[at]
        else:
            said = f"{slot.name}: {len(numbers)} for {count} samples"
            row[slot.place] = Reject("uneven", said)
    return row


def _add_date(row: Row, date: Date) -> None:
    if isinstance(date, Reject):
        row[-1] = (*row[-1], date)
    else:
        row[-2] = date
