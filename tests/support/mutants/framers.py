"""Framers that each break one promise."""

from typing import NamedTuple

from rosbase.framing import Frame, FrameError, FrameEvent, Framer, LineFramer
from rosbase.testing import FramerContract

__all__ = ["FRAMER_MUTANTS", "FramerMutant"]


class FramerMutant(NamedTuple):
    """What is wrong, which promise that breaks, and what the kit must have seen."""

    promise: str
    seen: str
    contract: type[FramerContract]


class LineContract(FramerContract):
    """Of lines."""

    framer: type[Framer] = LineFramer

    def make_framer(self) -> Framer:
        return self.framer()

    def encode(self, payload: bytes) -> bytes:
        return payload + b"\n"


class NoFramer(LineContract):
    def make_framer(self) -> None:  # type: ignore[override]  # which is what is wrong
        return None


class OneFramer(LineContract):
    only = LineFramer()

    def make_framer(self) -> Framer:
        return self.only


class NoEncoding(FramerContract):
    def make_framer(self) -> Framer:
        return LineFramer()


class NoReset(LineContract):
    def make_framer(self) -> object:  # type: ignore[override]  # which is what is wrong
        return type("Half", (), {"feed": LineFramer().feed})()


class Squeezing(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events = super().feed(data, stamp_ns)
        return [e._replace(data=e.data[:20]) if isinstance(e, Frame) else e for e in events]


class Unbuffered(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        self.reset()
        return super().feed(data, stamp_ns)


class Losing(LineFramer):
    """Of what comes after strange bytes it makes one frame of two."""

    held: Frame | None = None
    lost_place = False

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events: list[FrameEvent] = []
        for event in super().feed(data, stamp_ns):
            if isinstance(event, Frame) and self.held is not None:
                events.append(event._replace(data=self.held.data + event.data))
                self.held = None
            elif isinstance(event, Frame) and self.lost_place:
                self.held, self.lost_place = event, False
            else:
                # In whatever is no text, so that no search for one rare byte decides.
                self.lost_place = isinstance(event, Frame) and not event.data.isascii()
                events.append(event)
        return events


class Decoding(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return super().feed(data.decode().encode(), stamp_ns)


class Yielding(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return iter(super().feed(data, stamp_ns))  # type: ignore[return-value]  # which is what is wrong


class Growing(LineFramer):
    def __init__(self) -> None:
        super().__init__(1_000_000_000)


class StampingLate(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return [event._replace(stamp_ns=stamp_ns) for event in super().feed(data, stamp_ns)]


class StampingAnyhow(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events = super().feed(data, stamp_ns)
        return [e._replace(stamp_ns=e.stamp_ns - n) for n, e in enumerate(events)]


class Remembering:
    def __init__(self) -> None:
        self.inner = LineFramer()

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return self.inner.feed(data, stamp_ns)

    def reset(self) -> None:
        pass


class Talking(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return [
            event if isinstance(event, Frame) else event._replace(reason="line too long")
            for event in super().feed(data, stamp_ns)
        ]


class Telling(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        errors = [FrameError(f"error{number}", stamp_ns) for number in range(30)]
        return [*errors, *super().feed(data, stamp_ns)]


class Shared(Remembering):
    common = LineFramer()

    def __init__(self) -> None:
        self.inner = self.common


def of(framer: type[Framer]) -> type[FramerContract]:
    """The contract of lines, on another framer."""
    return type(framer.__name__, (LineContract,), {"framer": framer})


FRAMER_MUTANTS = [
    FramerMutant("a-framer-is-made", "make_framer gave None", NoFramer),
    FramerMutant("a-framer-is-made", "the same framer twice", OneFramer),
    FramerMutant("a-framer-is-made", "encode is not written yet", NoEncoding),
    FramerMutant("a-framer-is-made", "Half has no reset", NoReset),
    FramerMutant("frames-come-out-as-they-went-in", "came out as", of(Squeezing)),
    FramerMutant("chunking-does-not-matter", "in one piece", of(Unbuffered)),
    FramerMutant("junk-spoils-few-frames", "came", of(Losing)),
    FramerMutant("any-bytes-may-come", "raised UnicodeDecodeError", of(Decoding)),
    FramerMutant("any-bytes-may-come", "gave <list_iterator", of(Yielding)),
    FramerMutant("memory-is-bounded", "bytes more after", of(Growing)),
    FramerMutant("the-stamp-is-that-of-the-first-bytes", "were [200, 200]", of(StampingLate)),
    FramerMutant("stamps-never-go-back", "had the stamps", of(StampingAnyhow)),
    FramerMutant("reset-forgets-a-begun-frame", "after reset", of(Remembering)),
    FramerMutant("an-error-has-a-reason-of-one-word", "'line too long'", of(Talking)),
    FramerMutant("an-error-has-a-reason-of-one-word", "reasons", of(Telling)),
    FramerMutant("two-framers-share-nothing", "fed to two framers", of(Shared)),
]
