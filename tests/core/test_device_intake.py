"""From bytes to frames with stamps: what was read, and what waits behind it."""

from collections import deque
from itertools import pairwise

import pytest

from rosbase.contracts.stamper import Stamper
from rosbase.contracts.transport import Tally, TransportContext
from rosbase.device.intake import Intake
from rosbase.errors import TransportError
from rosbase.framing import Framer, LineFramer
from rosbase.logger import RosbaseLogger
from rosbase.testing import ManualClock

MS = 1_000_000


class Rig:
    """A device on a clock that the test turns: a queue of what waits to be read."""

    def __init__(self, framer: Framer | None, bytes_per_s: float | None = None) -> None:
        self.clock = ManualClock()
        self.tally = Tally()
        context = TransportContext(self.clock, RosbaseLogger("intake", self.clock))
        self.stamper = Stamper(context, self.tally)
        self.frames: list[tuple[bytes, int]] = []
        self.intake = Intake(framer, self.keep, context, self.tally, self.stamper)
        self.waiting: deque[bytes | TransportError] = deque()
        self.waits_ms: list[float] = []
        self.bytes_per_s = bytes_per_s
        self.work_s = 0.0
        self.intake.begin(self)  # type: ignore[arg-type]  # as much of a device as is looked at

    def keep(self, frame: bytes, stamp_ns: int) -> None:
        self.clock.advance(self.work_s)
        self.frames.append((frame, stamp_ns))

    def read_more(self, timeout_ms: float) -> bytes:
        self.waits_ms.append(timeout_ms)
        data = self.waiting.popleft() if self.waiting else b""
        if isinstance(data, TransportError):
            raise data
        # A read takes its time.
        self.clock.advance(0.00001)
        return data

    def read(self, *data: bytes | TransportError, after_s: float = 0.01) -> list[bytes]:
        """Waits, reads the first and whatever is read with it; gives the frames."""
        self.frames.clear()
        self.clock.advance(after_s)
        self.waiting.extend(data)
        while self.waiting:
            self.intake.take(self.read_more(0), self.read_more)
        return [frame for frame, _ in self.frames]

    def steady(self) -> None:
        for number in range(50):
            assert self.read(b"%d\n" % number)
        self.waits_ms.clear()

    @property
    def gaps_ms(self) -> list[float]:
        return [(after[1] - before[1]) / MS for before, after in pairwise(self.frames)]


def test_a_frame_that_comes_alone_is_handed_over_without_looking_for_more() -> None:
    rig = Rig(LineFramer())
    rig.steady()
    assert rig.read(b"x\n") == [b"x"]
    assert rig.waits_ms == [0]
    assert rig.frames[0][1] == rig.clock.now_ns()


def test_a_frame_that_comes_alone_after_a_pause_waits_for_nothing() -> None:
    rig = Rig(LineFramer())
    rig.steady()
    assert rig.read(b"x\n", after_s=0.4) == [b"x"]
    # It looks whether there is more, at once.
    assert rig.waits_ms == [0, 0]


def test_what_waited_is_read_to_its_end_before_any_of_it_is_stamped() -> None:
    rig = Rig(LineFramer())
    rig.steady()
    lines = b"".join(b"line %d\n" % number for number in range(20))
    # As a terminal hands it over: in pieces that end anywhere.
    pieces = [lines[at : at + 37] for at in range(0, len(lines), 37)]
    assert rig.read(*pieces, after_s=0.2) == lines.split(b"\n")[:-1]
    assert all(9.5 < gap < 10.5 for gap in rig.gaps_ms)


def test_datagrams_that_waited_are_read_to_their_end_too() -> None:
    rig = Rig(None)
    rig.steady()
    assert len(rig.read(*[b"datagram"] * 20, after_s=0.2)) == 20
    assert all(9.5 < gap < 10.5 for gap in rig.gaps_ms)


def test_a_stall_before_half_a_frame_is_noticed() -> None:
    rig = Rig(LineFramer())
    rig.steady()
    lines = [b"line\n"] * 20
    assert len(rig.read(b"be", b"gun\n", *lines, after_s=0.21)) == 21
    assert all(9.5 < gap < 10.5 for gap in rig.gaps_ms)


def test_more_than_is_read_at_once_is_not_lost() -> None:
    rig = Rig(LineFramer())
    lines = [b"%06d " % number + b"x" * 193 for number in range(10_000)]
    data = b"\n".join(lines) + b"\n"
    assert rig.read(*[data[at : at + 4_096] for at in range(0, len(data), 4_096)]) == lines
    assert rig.tally.received_bytes == len(data)
    assert all(gap > 0 for gap in rig.gaps_ms)


def test_a_stream_that_never_pauses_is_read_on_for_a_moment_only() -> None:
    rig = Rig(LineFramer())
    rig.steady()
    rig.clock.advance(0.3)
    begun_ns = rig.clock.monotonic_ns()

    def read_more(timeout_ms: float) -> bytes:
        rig.clock.advance(0.0005)
        return b"x\n"

    rig.intake.take(b"x\n", read_more)
    assert rig.frames[-1][1] > rig.clock.now_ns() - MS
    assert rig.clock.monotonic_ns() - begun_ns < 200 * MS
    assert rig.tally.late_frames == 0


def test_a_flood_that_keeps_the_reader_busy_is_not_read_on_again_and_again() -> None:
    rig = Rig(LineFramer())
    rig.steady()
    rig.clock.advance(0.3)
    calls = 0

    def read_more(timeout_ms: float) -> bytes:
        nonlocal calls
        calls += 1
        rig.clock.advance(0.0005)
        return b"x\n" * 20

    # Handing over takes its time, and as long as it goes on, more arrives.
    rig.work_s = 0.000025
    rig.intake.take(b"x\n" * 20, read_more)
    first, calls = calls, 0
    assert first > 100
    for _ in range(100):
        rig.intake.take(b"x\n" * 20, read_more)
    assert calls == 0
    stamps = [stamp_ns for _, stamp_ns in rig.frames]
    assert stamps == sorted(set(stamps))


def test_frames_behind_which_the_device_is_lost_are_handed_over() -> None:
    rig = Rig(LineFramer())
    rig.steady()
    with pytest.raises(TransportError):
        rig.read(b"1\n2\n3\n", TransportError("unplugged"), after_s=0.5)
    assert [frame for frame, _ in rig.frames] == [b"1", b"2", b"3"]


def test_nothing_is_read_on_or_handed_over_after_the_end() -> None:
    rig = Rig(LineFramer())
    rig.steady()
    rig.frames.clear()
    rig.intake.is_ended = True
    rig.clock.advance(0.5)
    rig.intake.take(b"1\n2\n", rig.read_more)
    rig.intake.take(b"3\n", rig.read_more)
    assert (rig.frames, rig.waits_ms) == ([], [])


def test_what_cannot_be_a_frame_is_counted_once_whether_it_is_late_or_not() -> None:
    rig = Rig(LineFramer(max_line_bytes=10))
    rig.steady()
    assert rig.read(b"x" * 20 + b"\n1\n2\n") == [b"1", b"2"]
    assert rig.tally.frame_errors == {"overlong": 1}
    assert rig.read(b"x" * 20 + b"\n1\n2\n", after_s=10.0) == []
    assert rig.tally.frame_errors == {"overlong": 1, "late": 3}


def test_a_frame_that_is_begun_behind_another_leaves_room_for_its_own_stamp() -> None:
    rig = Rig(LineFramer())
    rig.steady()
    rig.read(b"whole\nbeg")
    (whole,) = rig.frames
    rig.read(b"un\n")
    (begun,) = rig.frames
    # The second began in the first read: both are of that moment at the latest, and 5 ms apart.
    assert begun[1] == rig.clock.now_ns() - 10 * MS - 10_000
    assert 4.9 < (begun[1] - whole[1]) / MS < 5.1


def test_frames_that_came_on_a_line_of_known_speed_are_as_close_as_they_were_there() -> None:
    # At 11,520 bytes a second, nine bytes take 0.78 ms.
    rig = Rig(LineFramer(), bytes_per_s=11_520)
    rig.steady()
    rig.read(b"acc 1234\nrot 1234\n")
    assert rig.gaps_ms == [pytest.approx(0.78, abs=0.01)]
    # Many at once have not come in one go.
    rig.read(*[b"line 123\n"] * 20, after_s=0.2)
    assert all(9.5 < gap < 10.5 for gap in rig.gaps_ms)
