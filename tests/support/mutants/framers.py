"""Framers that each break one promise."""

from typing import NamedTuple, cast

from hypothesis import strategies as st

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


class TrustingLengths:
    """Two marks, a length, and the payload: what is cut short swallows what comes after it."""

    MARKS = b"\xa5\x5a"

    def __init__(self) -> None:
        self.begun = b""

    def reset(self) -> None:
        self.begun = b""

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        self.begun += data
        events: list[FrameEvent] = []
        while (start := self.begun.find(self.MARKS)) >= 0:
            end = start + 4 + int.from_bytes(self.begun[start + 2 : start + 4], "big")
            if len(self.begun) < max(end, start + 4):
                break
            events.append(Frame(self.begun[start + 4 : end], stamp_ns))
            self.begun = self.begun[end:]
        return events


class OfLengths(LineContract):
    framer = TrustingLengths

    def encode(self, payload: bytes) -> bytes:
        return TrustingLengths.MARKS + len(payload).to_bytes(2, "big") + payload

    def junk(self) -> st.SearchStrategy[bytes]:
        return st.just(b"")


class Limited(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return super().feed(data, stamp_ns)[:20]


class GivingByteArrays(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return [
            event._replace(data=cast("bytes", bytearray(event.data)))
            if isinstance(event, Frame)
            else event
            for event in super().feed(data, stamp_ns)
        ]


class GivingSeconds(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return super().feed(data, float(stamp_ns))  # type: ignore[arg-type]  # which is what is wrong


class Hoarding(LineFramer):
    def __init__(self) -> None:
        super().__init__()
        self.kept: list[FrameEvent] = []

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events = super().feed(data, stamp_ns)
        self.kept += events
        return events


class Silent(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return [event for event in super().feed(data, stamp_ns) if isinstance(event, Frame)]


class Numbering(LineFramer):
    def __init__(self) -> None:
        super().__init__()
        self.number = 0

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return [self.numbered(event) for event in super().feed(data, stamp_ns)]

    def numbered(self, event: FrameEvent) -> FrameEvent:
        if isinstance(event, Frame):
            return event
        self.number += 1
        return event._replace(reason=f"{event.reason}-{self.number}")


class StampingByTheLastButOne(LineFramer):
    """A frame in three pieces has the stamp of the second."""

    def __init__(self) -> None:
        super().__init__()
        self.before_ns = 0

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events = super().feed(data, stamp_ns)
        before_ns, self.before_ns = self.before_ns, stamp_ns
        return [e._replace(stamp_ns=max(e.stamp_ns, before_ns)) for e in events]


class StampingAsTheError(LineFramer):
    """The frame after an error has the error's stamp, although it came later."""

    def __init__(self) -> None:
        super().__init__()
        self.error_ns: int | None = None

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return [self.stamped(event) for event in super().feed(data, stamp_ns)]

    def stamped(self, event: FrameEvent) -> FrameEvent:
        if not isinstance(event, Frame):
            self.error_ns = event.stamp_ns
        elif self.error_ns is not None:
            return event._replace(stamp_ns=self.error_ns)
        return event


class StillDiscarding(LineFramer):
    """After reset it goes on throwing away the rest of what was too long."""

    def reset(self) -> None:
        self._partial.clear()


class Unwritten:
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        raise NotImplementedError("step 3: cut frames")

    def reset(self) -> None:
        raise NotImplementedError("step 4: forget")


class GivingNothing(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> None:  # type: ignore[override]  # which is what is wrong
        super().feed(data, stamp_ns)


class Raising(LineContract):
    def make_framer(self) -> Framer:
        raise KeyError("table")


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


class PendingForEver(LineFramer):
    """Does not begin again where a frame ends."""

    fed = 0

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events = super().feed(data, stamp_ns)
        self.fed += len(data)
        self.pending_bytes = self.fed
        return events

    def reset(self) -> None:
        super().reset()
        self.fed = 0


class PendingOverReset(PendingForEver):
    def reset(self) -> None:
        pass


class PendingAsKept(LineFramer):
    """Of what is too long it keeps nothing, and says that nothing came."""

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events = super().feed(data, stamp_ns)
        self.pending_bytes = len(self._partial)
        return events


class PendingChunks(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events = super().feed(data, stamp_ns)
        self.pending_bytes = min(self.pending_bytes, 1)
        return events


def of(framer: type[Framer]) -> type[FramerContract]:
    """The contract of lines, on another framer."""
    return type(framer.__name__, (LineContract,), {"framer": framer})


FRAMER_MUTANTS = [
    FramerMutant("a-framer-is-made", "make_framer gave None", NoFramer),
    FramerMutant("a-framer-is-made", "the same framer twice", OneFramer),
    FramerMutant("a-framer-is-made", "encode is not written yet", NoEncoding),
    FramerMutant("a-framer-is-made", "Half has no reset", NoReset),
    FramerMutant("a-framer-is-made", "the framer raised KeyError('table')", Raising),
    FramerMutant("frames-come-out-as-they-went-in", "came out as", of(Squeezing)),
    FramerMutant("frames-come-out-as-they-went-in", "came out as", of(Limited)),
    FramerMutant("frames-come-out-as-they-went-in", "had bytearray and int", of(GivingByteArrays)),
    FramerMutant("frames-come-out-as-they-went-in", "had bytes and float", of(GivingSeconds)),
    FramerMutant("chunking-does-not-matter", "in one piece", of(Unbuffered)),
    FramerMutant("junk-spoils-few-frames", "came", of(Losing)),
    FramerMutant("junk-spoils-few-frames", "came", OfLengths),
    FramerMutant("any-bytes-may-come", "raised UnicodeDecodeError", of(Decoding)),
    FramerMutant("any-bytes-may-come", "gave <list_iterator", of(Yielding)),
    FramerMutant("memory-is-bounded", "without an end", of(Growing)),
    FramerMutant("memory-is-bounded", "in frames", of(Hoarding)),
    FramerMutant("what-is-too-long-is-an-error", "gave no FrameError", of(Silent)),
    FramerMutant("the-stamp-is-that-of-the-first-bytes", "were [300, 300]", of(StampingLate)),
    FramerMutant(
        "the-stamp-is-that-of-the-first-bytes", "were [200, 300]", of(StampingByTheLastButOne)
    ),
    FramerMutant("the-stamp-is-that-of-the-first-bytes", "fed junk at", of(StampingAsTheError)),
    FramerMutant("stamps-never-go-back", "had the stamps", of(StampingAnyhow)),
    FramerMutant("reset-forgets-a-begun-frame", "after reset", of(Remembering)),
    FramerMutant("reset-forgets-a-begun-frame", "after reset", of(StillDiscarding)),
    *(
        FramerMutant("pending-bytes-are-those-since-the-last-end", seen, of(framer))
        for seen, framer in (
            ("behind a whole frame of", PendingForEver),
            ("after reset", PendingOverReset),
            ("it was 0, not from 1 to 200000", PendingAsKept),
            ("after half a frame of", PendingChunks),
        )
    ),
    FramerMutant("an-error-has-a-reason-of-one-word", "'line too long'", of(Talking)),
    FramerMutant("an-error-has-a-reason-of-one-word", "there were 30 reasons", of(Numbering)),
    FramerMutant("an-error-has-a-reason-of-one-word", "reasons", of(Telling)),
    FramerMutant("two-framers-share-nothing", "fed to two framers", of(Shared)),
]
