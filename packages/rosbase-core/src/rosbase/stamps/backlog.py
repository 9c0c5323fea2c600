"""Frames that were read together: the time of each, and whether it can be known."""

from rosbase.stamps.spread import spread

__all__ = ["LATE_NS", "dates", "is_left_over", "is_undatable"]

LATE_NS = 1_000_000_000
"""Waiting time after which data is late, if no check came in between."""

# Frames that fill a wait but for this part of it are all there: a 16th.
_MISSING_SHIFT = 4
# As far as frames are put apart while nobody knows how far they usually are.
_UNKNOWN_NS = 10_000_000
# A UART hands over every few bytes. Where more whole frames come at once, they have waited.
_MOST_AT_ONCE = 4


def is_undatable(count: int, waited_ns: int, usual_ns: int) -> bool:
    """Return whether the times of frames that have waited for long cannot be known.

    If there are as many as usually come in that time, each came when it was due. If some are
    missing, a buffer has overrun, and it is not known which ones are lost.

    Args:
        count: Number of frames.
        waited_ns: Time that they may have waited.
        usual_ns: The usual interval; 0 if it is not known.
    """
    missing_ns = waited_ns - count * usual_ns
    return not usual_ns or missing_ns >= max(usual_ns, waited_ns >> _MISSING_SHIFT)


def is_left_over(count: int, waited_ns: int, usual_ns: int) -> bool:
    """Return whether there are too many frames for the time since the previous read.

    After a read that was undatable, they are the rest of the waiting frames.
    """
    return usual_ns > 0 and count * usual_ns > 2 * (waited_ns + usual_ns)


def dates(
    count: int,
    after_ns: int,
    until_ns: int,
    waited_ns: int,
    usual_ns: int,
    wire_ns: int | None = None,
) -> range:
    """Return the dates of frames that were read together.

    Args:
        count: Number of frames.
        after_ns: A date before the first of them.
        until_ns: The date of the read.
        waited_ns: Time that they may have waited.
        usual_ns: The usual interval; 0 if it is not known.
        wire_ns: Time of a frame on the line, if that is known.
    """
    widest_ns = usual_ns or _UNKNOWN_NS
    if wire_ns is not None and count <= _MOST_AT_ONCE:
        return spread(count, after_ns, until_ns, min(widest_ns, wire_ns))
    fill_ns = count * usual_ns
    if 0 <= waited_ns - fill_ns < usual_ns and (count > 1 or waited_ns > LATE_NS):
        # They fill the wait: each came a usual interval after the one before.
        until_ns = min(until_ns, after_ns + fill_ns)
    return spread(count, after_ns, until_ns, widest_ns)
