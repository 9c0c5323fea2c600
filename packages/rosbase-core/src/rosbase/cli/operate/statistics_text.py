"""`rosbase stats`."""

from __future__ import annotations

from math import log

from rosbase.cli.operate.columns import columns, long_tick, milliseconds
from rosbase.control.questions.programs import ProgramQuestions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rosbase.control.shapes import Statistics

__all__ = ["show_statistics"]

_MARKS = (("min", "min_ns"), ("50 %", "p50"), ("90 %", "p90"), ("99 %", "p99"),
          ("99.9 %", "p999"), ("max", "max_ns"))  # fmt: skip
_BAR = 40
_MOST_ROWS = 16


def show_statistics(given: Any) -> None:
    """Print the times of the ticks, with histograms, or as JSON."""
    found = [one for one in ProgramQuestions(given.program).statistics() if one.get("period")]
    if given.json:
        import json

        print(json.dumps(found, indent=2))
        return
    print("\n\n".join(map(_text, found)) or "no program has a main loop")


def _text(one: Statistics) -> str:
    rate = one.get("rate_hz")
    asked = "" if rate is None else f" at {rate:g} Hz"
    head = f"{one['program'].lstrip('/')} [{one['pid']}]: {one['ticks']} ticks{asked}"
    rows = [("", *(name for name, _ in _MARKS))]
    for title, times in (("period", one["period"]), ("busy", one["busy"])):
        rows.append((title, *(milliseconds(times.get(key)) for _, key in _MARKS)))
    table = columns(rows, right=range(1, len(_MARKS) + 1))
    hanging = long_tick(one.get("tick_ns"), rate)
    return "\n".join(
        [
            f"{head}, {one['overruns']} overruns",
            *([f"the current tick has taken {hanging} so far"] if hanging else []),
            table,
            *_histogram("period", one["period"]["histogram"]),
            *_histogram("busy", one["busy"]["histogram"]),
        ]
    )


def _histogram(title: str, buckets: list[list[int]]) -> list[str]:
    """Return a line for each bucket that has any: its upper end, its count, and a bar."""
    used = _coarser([(upper, count) for upper, count in buckets if count])
    if not used:
        return []
    most = max(count for _, count in used)
    rows = [
        (f"up to {milliseconds(upper)}", str(count), "#" * max(1, round(_BAR * count / most)))
        for upper, count in used
    ]
    return ["", f"{title}:", *(f"  {line}" for line in columns(rows, right=(0, 1)).split("\n"))]


def _coarser(buckets: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return the counts in at most 16 buckets, whose ends grow by a factor."""
    if len(buckets) <= _MOST_ROWS:
        return buckets
    first, last = max(1, buckets[0][0]), buckets[-1][0]
    factor = (last / first) ** (1.0 / (_MOST_ROWS - 1))
    counts: dict[int, list[int]] = {}
    for upper, count in buckets:
        number = 0 if factor <= 1.0 else round(log(max(1, upper) / first) / log(factor))
        known = counts.setdefault(number, [0, 0])
        known[0], known[1] = upper, known[1] + count
    return [(upper, count) for upper, count in counts.values()]
