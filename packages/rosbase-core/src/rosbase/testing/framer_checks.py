"""Checks of a framer, each a plain function: for `FramerContract`, and for any other test."""

from collections.abc import Callable, Iterable, Sequence
from typing import TypeAlias

from rosbase.framing import Frame, FrameError, FrameEvent, Framer
from rosbase.testing.framer_promises import (
    CHUNKING,
    JUNK,
    MEMORY,
    NOT_RAISING,
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
    "check_reset_forgets_a_begun_frame",
    "check_stamp_is_that_of_the_first_bytes",
    "check_stamps_never_go_back",
    "check_two_framers_share_nothing",
]

MakeFramer: TypeAlias = Callable[[], Framer]
Encode: TypeAlias = Callable[[bytes], bytes]
"""The bytes of one frame with that payload, delimiters included."""

_MOST_REASONS = 20


def check_frames_come_out_as_they_went_in(
    make_framer: MakeFramer, encode: Encode, payloads: Sequence[bytes]
) -> None:
    """Raises BrokenPromiseError if payloads do not come out as frames, as they were."""
    came = _frames(make_framer().feed(b"".join(map(encode, payloads)), 0))
    UNALTERED.require(came == list(payloads), f"{_shown(payloads)} came out as {_shown(came)}")


def check_chunking_does_not_matter(make_framer: MakeFramer, chunks: Sequence[bytes]) -> None:
    """Raises BrokenPromiseError if chunks give something else than all of them in one piece."""
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
    """Raises BrokenPromiseError if more than `most_lost` frames after junk are not whole."""
    came = _frames(make_framer().feed(junk + b"".join(map(encode, payloads)), 0))
    wanted = list(payloads[most_lost:])
    last = came[len(came) - len(wanted) :] if len(wanted) <= len(came) else came
    seen = f"after {_shown([junk])} came {_shown(came)} of {_shown(payloads)}"
    JUNK.require(last == wanted, seen)


def check_any_bytes_may_come(make_framer: MakeFramer, chunks: Iterable[bytes]) -> None:
    """Raises BrokenPromiseError if the framer raises, or gives what is no event."""
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
    """Raises BrokenPromiseError if it keeps more than the limit of so much without an end."""
    framer = make_framer()
    with memory_growth() as growth:
        for _ in range(fed_bytes // len(endless)):
            framer.feed(endless, 0)
        grown = growth()
    MEMORY.require(grown < limit_bytes, f"{grown} bytes more after {fed_bytes} without an end")


def check_stamp_is_that_of_the_first_bytes(
    make_framer: MakeFramer, encode: Encode, payload: bytes
) -> None:
    """Raises BrokenPromiseError if a frame that is fed in two halves has another stamp."""
    framer = make_framer()
    encoded = encode(payload)
    half = len(encoded) // 2
    events = framer.feed(encoded[:half], 100) + framer.feed(encoded[half:] + encoded, 200)
    stamps = [event.stamp_ns for event in events]
    seen = f"fed half at 100, half and a whole one at 200; the stamps were {stamps}"
    STAMPS.require(stamps == [100, 200], seen)


def check_stamps_never_go_back(make_framer: MakeFramer, chunks: Sequence[bytes]) -> None:
    """Raises BrokenPromiseError if events of chunks fed one after the other go back in time."""
    framer = make_framer()
    fed = ((chunk, number * 100) for number, chunk in enumerate(chunks, start=1))
    stamps = [event.stamp_ns for chunk, now_ns in fed for event in framer.feed(chunk, now_ns)]
    STAMP_ORDER.require(stamps == sorted(stamps), f"{list(chunks)} had the stamps {stamps}")


def check_reset_forgets_a_begun_frame(
    make_framer: MakeFramer, encode: Encode, begun: bytes, payload: bytes
) -> None:
    """Raises BrokenPromiseError if, after reset, a begun frame is continued."""
    framer = make_framer()
    encoded = encode(begun)
    framer.feed(encoded[: len(encoded) // 2], 100)
    framer.reset()
    events = framer.feed(encode(payload), 200)
    RESET.require(events == [Frame(payload, 200)], f"after reset, {payload!r} gave {events}")


def check_error_reasons(make_framer: MakeFramer, chunks: Iterable[bytes]) -> None:
    """Raises BrokenPromiseError if an error has no reason, one of several words, or ever new."""
    framer = make_framer()
    events = [event for chunk in chunks for event in framer.feed(chunk, 0)]
    reasons = {event.reason for event in events if isinstance(event, FrameError)}
    for reason in reasons:
        REASONS.require(len(reason.split()) == 1, f"a reason was {reason!r}")
    REASONS.require(len(reasons) <= _MOST_REASONS, f"there were {len(reasons)} reasons")


def check_two_framers_share_nothing(
    make_framer: MakeFramer, encode: Encode, begun: bytes, payload: bytes
) -> None:
    """Raises BrokenPromiseError if a frame begun in one framer shows in another."""
    one, other = make_framer(), make_framer()
    encoded = encode(begun)
    half = len(encoded) // 2
    one.feed(encoded[:half], 0)
    others = _frames(other.feed(encode(payload), 0))
    ones = _frames(one.feed(encoded[half:], 0))
    seen = f"of {begun!r} and {payload!r}, fed to two framers, came {ones} and {others}"
    SEPARATE.require((ones, others) == ([begun], [payload]), seen)


def _frames(events: Iterable[FrameEvent]) -> list[bytes]:
    return [event.data for event in events if isinstance(event, Frame)]


def _outcome(framer: Framer, chunks: Iterable[bytes]) -> list[bytes | str]:
    events = [event for chunk in chunks for event in framer.feed(chunk, 0)]
    return [event.data if isinstance(event, Frame) else event.reason for event in events]


def _shown(frames: Iterable[bytes]) -> str:
    return ", ".join(repr(f) if len(f) <= 60 else f"{f[:40]!r}..." for f in frames) or "nothing"
