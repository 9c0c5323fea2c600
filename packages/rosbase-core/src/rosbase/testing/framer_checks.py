"""Checks of a framer as plain functions, for `FramerContract` and other tests."""

from collections.abc import Callable, Iterable, Sequence
from typing import TypeAlias

from rosbase.framing import Frame, FrameError, FrameEvent, Framer
from rosbase.testing.framer_promises import (
    CHUNKING,
    ERRORS,
    JUNK,
    MEMORY,
    NOT_RAISING,
    PENDING,
    REASONS,
    RESET,
    SEPARATE,
    STAMP_ORDER,
    STAMPS,
    UNALTERED,
)
from rosbase.testing.resources import memory_growth

__all__ = [
    "Encode",
    "MakeFramer",
    "check_any_bytes_may_come",
    "check_chunking_does_not_matter",
    "check_error_reasons",
    "check_frames_come_out_as_they_went_in",
    "check_junk_spoils_few_frames",
    "check_memory_is_bounded",
    "check_memory_is_bounded_while_frames_come",
    "check_pending_bytes",
    "check_reset_forgets_a_begun_frame",
    "check_stamp_after_junk",
    "check_stamp_is_that_of_the_first_bytes",
    "check_stamps_never_go_back",
    "check_two_framers_share_nothing",
    "check_what_is_too_long_is_an_error",
]

MakeFramer: TypeAlias = Callable[[], Framer]
"""Return a new framer each time."""
Encode: TypeAlias = Callable[[bytes], bytes]
"""Return the bytes of one frame with that payload, delimiters included."""

_MOST_REASONS = 20
_LONGEST_BYTES = 70_000
_MOST_SHOWN = 10


def check_frames_come_out_as_they_went_in(
    make_framer: MakeFramer, encode: Encode, payloads: Sequence[bytes]
) -> None:
    """Raise BrokenPromiseError if payloads do not come out as unaltered frames."""
    events = make_framer().feed(b"".join(map(encode, payloads)), 0)
    came = _frames(events)
    UNALTERED.require(came == list(payloads), f"{_shown(payloads)} came out as {_shown(came)}")
    for event in events:
        kinds = [type(value).__name__ for value in event]
        UNALTERED.require(kinds == ["bytes", "int"], f"a frame had {' and '.join(kinds)}")


def check_chunking_does_not_matter(make_framer: MakeFramer, chunks: Sequence[bytes]) -> None:
    """Raise BrokenPromiseError if chunks give other events than the same bytes in one piece."""
    whole = _outcome(make_framer(), [b"".join(chunks)])
    cut = _outcome(make_framer(), chunks)
    CHUNKING.require(cut == whole, f"in one piece {whole}; cut into {list(chunks)}: {cut}")


def check_junk_spoils_few_frames(
    make_framer: MakeFramer,
    encode: Encode,
    junk: bytes,
    payloads: Sequence[bytes],
    most_lost: int = 1,
) -> None:
    """Raise BrokenPromiseError if more than `most_lost` frames after junk are incomplete.

    Frames may come late: a truncated frame may announce more bytes than it has.
    """
    framer = make_framer()
    came = _frames(framer.feed(junk + b"".join(map(encode, payloads)), 0))
    wanted = list(payloads[most_lost:])
    if came[len(came) - len(wanted) :] != wanted or len(came) < len(wanted):
        late, count = _flush(framer, encode, payloads[-1], 0)
        came, wanted = came + _frames(late), wanted + [payloads[-1]] * count
    last = came[len(came) - len(wanted) :] if len(wanted) <= len(came) else came
    seen = f"after {_shown([junk])} came {_shown(came)} of {_shown(payloads)}"
    JUNK.require(last == wanted, seen)


def check_any_bytes_may_come(make_framer: MakeFramer, chunks: Iterable[bytes]) -> None:
    """Raise BrokenPromiseError if the framer raises, or returns a value that is no event."""
    framer = make_framer()
    for chunk in chunks:
        try:
            events = framer.feed(chunk, 0)
        except Exception as error:
            raise NOT_RAISING.broken(f"feed({chunk!r}) raised {error!r}") from error
        is_so = isinstance(events, list) and all(isinstance(e, Frame | FrameError) for e in events)
        NOT_RAISING.require(is_so, f"feed({chunk!r}) gave {events!r}")


def check_memory_is_bounded(
    make_framer: MakeFramer, endless: bytes, *, limit_bytes: int, fed_bytes: int
) -> None:
    """Raise BrokenPromiseError if it keeps more than the limit of bytes without an end."""
    framer = make_framer()
    with memory_growth() as growth:
        for _ in range(fed_bytes // len(endless)):
            framer.feed(endless, 0)
        grown = growth()
    MEMORY.require(grown < limit_bytes, f"{grown} bytes more after {fed_bytes} without an end")


def check_memory_is_bounded_while_frames_come(
    make_framer: MakeFramer, encode: Encode, payload: bytes, *, limit_bytes: int, fed_bytes: int
) -> None:
    """Raise BrokenPromiseError if it keeps frames that have come out."""
    framer, encoded = make_framer(), encode(payload)
    several = encoded * (1 + 1_000 // len(encoded))
    with memory_growth() as growth:
        for _ in range(fed_bytes // len(several)):
            # A copy, because the same object costs nothing when it piles up.
            framer.feed(bytes(bytearray(several)), 0)
        grown = growth()
    MEMORY.require(grown < limit_bytes, f"{grown} bytes more after {fed_bytes} in frames")


def check_what_is_too_long_is_an_error(
    make_framer: MakeFramer, encode: Encode, endless: bytes, payload: bytes, most_lost: int = 1
) -> None:
    """Raise BrokenPromiseError if so many bytes without an end give no FrameError."""
    framer = make_framer()
    events = framer.feed(endless, 0) + framer.feed(encode(payload) * (most_lost + 1), 0)
    has_error = any(isinstance(event, FrameError) for event in events)
    ERRORS.require(has_error, f"{len(endless)} bytes without an end gave no FrameError")


def check_stamp_is_that_of_the_first_bytes(
    make_framer: MakeFramer, encode: Encode, payload: bytes
) -> None:
    """Raise BrokenPromiseError if a frame fed in three pieces lacks the stamp of the first."""
    framer = make_framer()
    encoded = encode(payload)
    third = len(encoded) // 3
    events = framer.feed(encoded[:third], 100) + framer.feed(encoded[third : 2 * third], 200)
    events += framer.feed(encoded[2 * third :] + encoded, 300)
    stamps = [event.stamp_ns for event in events]
    seen = f"fed in thirds at 100, 200 and 300, with a whole one behind; the stamps were {stamps}"
    STAMPS.require(stamps == [100, 300], seen)


def check_stamp_after_junk(
    make_framer: MakeFramer, encode: Encode, junk: bytes, payload: bytes, most_lost: int = 1
) -> None:
    """Raise BrokenPromiseError if a frame after junk has an earlier stamp than its own."""
    framer = make_framer()
    framer.feed(junk, 100)
    framer.feed(encode(payload) * most_lost, 200)
    events = framer.feed(encode(payload), 300)
    if not events:
        events, _ = _flush(framer, encode, payload, 400)
    stamps = [event.stamp_ns for event in events if isinstance(event, Frame)]
    seen = f"fed junk at 100, frames at 200, and one at 300; the last had the stamps {stamps[:5]}"
    STAMPS.require(300 in stamps, seen)


def check_stamps_never_go_back(make_framer: MakeFramer, chunks: Sequence[bytes]) -> None:
    """Raise BrokenPromiseError if the stamps of consecutive events go back in time."""
    framer = make_framer()
    fed = ((chunk, number * 100) for number, chunk in enumerate(chunks, start=1))
    stamps = [event.stamp_ns for chunk, now_ns in fed for event in framer.feed(chunk, now_ns)]
    STAMP_ORDER.require(stamps == sorted(stamps), f"{list(chunks)} had the stamps {stamps}")


def check_reset_forgets_a_begun_frame(
    make_framer: MakeFramer, encode: Encode, begun: bytes, payload: bytes
) -> None:
    """Raise BrokenPromiseError if an incomplete frame is continued after reset.

    Args:
        make_framer: Makes a framer.
        encode: Encodes a payload.
        begun: The bytes fed before reset: a part of a frame, or bytes that never end one.
        payload: The payload fed after reset.
    """
    framer = make_framer()
    framer.feed(begun, 100)
    framer.reset()
    events = framer.feed(encode(payload), 200)
    RESET.require(events == [Frame(payload, 200)], f"after reset, {payload!r} gave {events}")


def check_pending_bytes(
    make_framer: MakeFramer, encode: Encode, endless: bytes, payload: bytes, most_lost: int = 1
) -> bool:
    """Raise BrokenPromiseError if `pending_bytes` is wrong; return False if there is none."""
    framer, encoded = make_framer(), encode(payload)

    def require(least: int, most: int, when: str) -> None:
        said = getattr(framer, "pending_bytes", None)
        is_so = isinstance(said, int) and least <= said <= most
        seen = f"{least}" if least == most else f"from {least} to {most}"
        PENDING.require(is_so, f"it was {said!r}, not {seen}, {when}")

    framer.feed(endless, 0)
    if not hasattr(framer, "pending_bytes"):
        return False
    # A frame given up as too long may count as an end.
    require(1, len(endless), f"after {len(endless)} bytes that never end a frame")
    framer.reset()
    require(0, 0, "after reset")
    framer.feed(encoded * (most_lost + 1), 0)
    require(0, len(encoded), f"behind a whole frame of {len(encoded)} bytes")
    framer.reset()
    half = len(encoded) // 2
    framer.feed(encoded[:half], 0)
    require(half, half, f"after half a frame of {len(encoded)} bytes")
    return True


def check_error_reasons(make_framer: MakeFramer, chunks: Iterable[bytes]) -> None:
    """Raise BrokenPromiseError if a reason is empty, has several words, or is always new."""
    framer = make_framer()
    events = [event for chunk in chunks for event in framer.feed(chunk, 0)]
    reasons = {event.reason for event in events if isinstance(event, FrameError)}
    for reason in reasons:
        REASONS.require(len(reason.split()) == 1, f"a reason was {reason!r}")
    REASONS.require(len(reasons) <= _MOST_REASONS, f"there were {len(reasons)} reasons")


def check_two_framers_share_nothing(
    make_framer: MakeFramer, encode: Encode, begun: bytes, payload: bytes
) -> None:
    """Raise BrokenPromiseError if a frame begun in one framer shows in another."""
    one, other = make_framer(), make_framer()
    encoded = encode(begun)
    half = len(encoded) // 2
    one.feed(encoded[:half], 0)
    others = _frames(other.feed(encode(payload), 0))
    ones = _frames(one.feed(encoded[half:], 0))
    seen = f"of {begun!r} and {payload!r}, fed to two framers, came {ones} and {others}"
    SEPARATE.require((ones, others) == ([begun], [payload]), seen)


def _flush(
    framer: Framer, encode: Encode, payload: bytes, stamp_ns: int
) -> tuple[list[FrameEvent], int]:
    """Feed enough frames to end anything begun; return the events and the number of frames."""
    encoded = encode(payload)
    count = 1 + _LONGEST_BYTES // len(encoded)
    return framer.feed(encoded * count, stamp_ns), count


def _frames(events: Iterable[FrameEvent]) -> list[bytes]:
    return [event.data for event in events if isinstance(event, Frame)]


def _outcome(framer: Framer, chunks: Iterable[bytes]) -> list[bytes | str]:
    events = [event for chunk in chunks for event in framer.feed(chunk, 0)]
    return [event.data if isinstance(event, Frame) else event.reason for event in events]


def _shown(frames: Iterable[bytes]) -> str:
    shown = [repr(f) if len(f) <= 60 else f"{f[:40]!r}..." for f in frames]
    more = ["..."] if len(shown) > _MOST_SHOWN else []
    return ", ".join(shown[:_MOST_SHOWN] + more) or "nothing"
