"""Tables, sizes and durations for people to read. Pure."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

__all__ = ["columns", "duration", "long_tick", "milliseconds", "size"]

_GAP = "  "
_LONG_TICK_NS = 1_000_000_000


def columns(rows: Sequence[Sequence[str]], right: Collection[int] = ()) -> str:
    """Return rows as a table; the columns with these numbers are aligned at the right."""
    # Names come from other programs.
    from rosbase.text.printable import printable

    safe = [[printable(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*safe, strict=True)]
    return "\n".join(
        _GAP.join(
            f"{cell:>{width}}" if number in right else f"{cell:{width}}"
            for number, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in safe
    )


def size(count: int | None) -> str:
    """Return a number of bytes, such as `23.4 MB`."""
    if count is None:
        return "-"
    value = float(count)
    for unit in ("B", "kB", "MB", "GB"):
        if value < 1000.0 or unit == "GB":
            break
        value /= 1000.0
    return f"{value:.0f} {unit}" if unit == "B" else f"{value:.1f} {unit}"


def duration(time_ns: int) -> str:
    """Return a duration, such as `45 s`, `12:03` or `2 d 03:15`."""
    seconds = time_ns // 1_000_000_000
    if seconds < 60:
        return f"{seconds} s"
    minutes, seconds = divmod(seconds, 60)
    if minutes < 60:
        return f"{minutes}:{seconds:02d}"
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    clock = f"{hours:02d}:{minutes:02d}"
    return f"{days} d {clock}" if days else f"{clock}:{seconds:02d}"


def long_tick(tick_ns: int | None, rate_hz: float | None) -> str:
    """Return how long a tick has taken so far if it hangs, such as `30 s`; empty if it does not."""
    least_ns = max(_LONG_TICK_NS, 2e9 / (rate_hz or 1.0))
    return "" if tick_ns is None or tick_ns < least_ns else duration(tick_ns)


def milliseconds(time_ns: float | None) -> str:
    """Return a duration in milliseconds, with microseconds behind the point."""
    return "-" if time_ns is None else f"{time_ns / 1e6:.3f} ms"
