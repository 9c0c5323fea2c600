"""Sizes, time spans and dates as users type them. Pure."""

import argparse
import math
import re
from datetime import datetime, timezone

__all__ = ["moment_ns", "moments_ns", "size_bytes", "span_ns"]

_NUMBER = re.compile(r"(\d+(?:\.\d+)?)\s*([a-zA-Z]*)")
_SIZES = {"": 1, "B": 1, "K": 10**3, "KB": 10**3, "M": 10**6, "MB": 10**6, "G": 10**9, "GB": 10**9}
_SPANS_S = {"": 1, "S": 1, "MS": 1e-3, "M": 60, "MIN": 60, "H": 3600}


def size_bytes(text: str) -> int:
    """Return a size such as `500MB` in bytes.

    Raises:
        argparse.ArgumentTypeError: It is none.
    """
    return int(_read(text, _SIZES, "a size such as 500MB"))


def span_ns(text: str) -> int:
    """Return a time span such as `60s` or `10min` in nanoseconds.

    Raises:
        argparse.ArgumentTypeError: It is none.
    """
    return int(_read(text, _SPANS_S, "a time span such as 60s or 10min") * 1e9)


def moment_ns(text: str, start_ns: int) -> int:
    """Return a moment of a recording in nanoseconds since 1970.

    Args:
        text: A date of ISO 8601, in UTC unless it says otherwise; or a time span from the start.
        start_ns: The start.

    Raises:
        argparse.ArgumentTypeError: It is neither.
    """
    if ("-" in text or ":" in text) and not text.startswith("-"):
        try:
            date = datetime.fromisoformat(text.replace("Z", "+00:00"))
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is no date of ISO 8601") from None
        date = date if date.tzinfo else date.replace(tzinfo=timezone.utc)
        whole = datetime(1970, 1, 1, tzinfo=timezone.utc)
        gone = date - whole
        return (gone.days * 86_400 + gone.seconds) * 10**9 + gone.microseconds * 1_000
    return start_ns + span_ns(text)


def moments_ns(start: str | None, end: str | None, start_ns: int) -> tuple[int | None, int | None]:
    """Return two moments of a recording, as `moment_ns` does; None stays None.

    Args:
        start: The value of `--from`.
        end: The value of `--to`.
        start_ns: The start of the recording.

    Raises:
        argparse.ArgumentTypeError: One is none, or nothing is between them.
    """
    first = None if start is None else moment_ns(start, start_ns)
    last = None if end is None else moment_ns(end, start_ns)
    if last is not None and last < start_ns:
        raise argparse.ArgumentTypeError(f"--to {end} is before the start of the recording")
    if first is not None and last is not None and first > last:
        raise argparse.ArgumentTypeError(f"--from {start} is after --to {end}")
    return first, last


def _read(text: str, units: dict[str, int] | dict[str, float], kind: str) -> float:
    found = _NUMBER.fullmatch(text.strip())
    factor = units.get(found[2].upper()) if found else None
    if found is None or factor is None or not math.isfinite(float(found[1])):
        raise argparse.ArgumentTypeError(f"{text!r} is not {kind}")
    return float(found[1]) * factor
