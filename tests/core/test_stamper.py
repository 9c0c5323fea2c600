"""What is counted and said of stamps."""

from itertools import pairwise

import pytest

from rosbase.contracts.stamper import Stamper
from rosbase.contracts.transport import Tally, TransportContext, TransportState
from rosbase.logger import RosbaseLogger
from rosbase.testing import ManualClock

MS = 1_000_000


class Rig:
    """A stamper on a clock that the test turns."""

    def __init__(self, *, frames_are_dated: bool = False) -> None:
        self.clock = ManualClock()
        self.tally = Tally()
        logger = RosbaseLogger("stamper", self.clock)
        context = TransportContext(self.clock, logger, frames_are_dated=frames_are_dated)
        self.stamper = Stamper(context, self.tally)

    def read(self, after_s: float, frames: int = 1) -> list[int | None]:
        """The stamps of frames that are read after a while, as ages in milliseconds."""
        self.clock.advance(after_s)
        at_ns = self.stamper.read()
        stamp_ns = self.stamper.one(at_ns) if frames == 1 else None
        stamps = [stamp_ns] if stamp_ns is not None else self.stamper.many([at_ns] * frames)
        now_ns = self.clock.now_ns()
        return [None if stamp is None else (now_ns - stamp) // MS for stamp in stamps]

    def steady(self) -> None:
        for _ in range(50):
            assert self.read(0.01) == [0]


@pytest.fixture
def rig(caplog: pytest.LogCaptureFixture) -> Rig:
    caplog.set_level("INFO", logger="rosbase")
    return Rig()


def test_in_the_usual_case_nothing_is_said(rig: Rig, caplog: pytest.LogCaptureFixture) -> None:
    rig.steady()
    health = rig.tally.health(TransportState.CONNECTED)
    assert (health.interval_ns, health.jitter_ns) == (10 * MS, 0)
    assert (health.clock_steps, health.late_frames) == (0, 0)
    assert caplog.messages == []


def test_a_stall_whose_frames_are_all_there_is_counted_and_said(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    rig.steady()
    ages = rig.read(10.0, 1000)
    assert ages == [10 * n for n in reversed(range(1000))]
    assert rig.tally.late_frames == 899
    assert rig.tally.frame_errors == {}
    assert caplog.messages == [
        "nothing was read for 10.0 s: 899 frames had waited for over a second"
    ]


def test_a_stall_with_frames_missing_is_counted_and_said_once(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    rig.steady()
    assert rig.read(10.0, 320) == [None] * 320
    assert rig.read(0.001, 20) == [None] * 20
    assert rig.read(0.01) == [0]
    assert rig.tally.late_frames == 340
    assert rig.tally.frame_errors == {"late": 340}
    assert caplog.messages == [
        "nothing was read for 10.0 s: 320 frames that had waited are dropped, because fewer "
        "have come than usual, so their arrival times are unknown"
    ]


def test_frames_that_carry_dates_are_counted_and_not_dropped(
    caplog: pytest.LogCaptureFixture,
) -> None:
    rig = Rig(frames_are_dated=True)
    rig.steady()
    assert rig.read(10.0, 3) == [20, 10, 0]
    assert (rig.tally.late_frames, rig.tally.frame_errors) == (3, {})
    assert rig.read(0.01) == [0]
    assert rig.tally.late_frames == 3
    assert len(caplog.messages) == 1


@pytest.mark.parametrize(("step_s", "way"), [(3_600, "forward"), (-3_600, "back")])
def test_a_date_that_is_set_is_counted_and_said_and_followed(
    rig: Rig, caplog: pytest.LogCaptureFixture, step_s: int, way: str
) -> None:
    rig.steady()
    rig.clock.date_ns += step_s * 1000 * MS
    assert rig.read(0.01) == [0]
    rig.steady()
    assert rig.read(0.01, 2) == [5, 0]
    assert rig.tally.clock_steps == 1
    assert caplog.messages == [f"the clock was set {way} by 3600.000 s; stamps follow it"]


def test_a_date_that_is_set_again_and_again_is_said_at_a_limited_rate(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    # As with a simulation's /clock, which stands still between two messages.
    for number in range(100):
        rig.clock.date_ns -= 10 * MS
        ages = rig.read(0.01)
        assert ages == [0], number
    assert rig.tally.clock_steps >= 49
    assert len(caplog.messages) == 1


def test_what_came_before_the_machine_slept_is_late_and_the_clock_was_not_set(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    rig.steady()
    rig.clock.advance(0.3)
    rig.clock.suspend(7_200.0)
    assert rig.read(0.3, 40) == [None] * 40
    rig.steady()
    assert (rig.tally.clock_steps, rig.tally.frame_errors) == (0, {"late": 40})
    (said,) = caplog.messages
    assert said.startswith("nothing was read for 7200.6 s: 40 frames that had waited")


def test_a_machine_that_slept_while_nothing_was_read_is_no_step_of_the_clock(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    rig.steady()
    rig.clock.suspend(7_200.0)
    rig.stamper.begin()
    rig.steady()
    assert rig.tally.clock_steps == 0
    assert caplog.messages == []


def test_what_is_read_piece_by_piece_after_a_stall_is_stamped_together(rig: Rig) -> None:
    rig.steady()
    rig.clock.advance(0.2)
    moments = [rig.stamper.read()] * 19
    assert rig.stamper.wants_more
    rig.clock.advance(0.001)
    moments.append(rig.stamper.more())
    stamps = rig.stamper.many(moments)
    gaps = {round(((after or 0) - (before or 0)) / MS) for before, after in pairwise(stamps)}
    assert gaps == {10}


def test_a_device_that_is_silent_is_looked_at_and_what_comes_then_is_new(rig: Rig) -> None:
    rig.steady()
    for _ in range(20):
        rig.clock.advance(0.5)
        rig.stamper.look(rig.clock.monotonic_ns())
    assert rig.read(0.4, 3) == [20, 10, 0]
    assert rig.tally.late_frames == 0


def test_whoever_comes_back_late_from_a_look_does_not_know_what_has_arrived_since(
    rig: Rig,
) -> None:
    rig.steady()
    until_ns = rig.clock.monotonic_ns() + 500 * MS
    # Somebody else had the interpreter.
    rig.clock.advance(3.0)
    rig.stamper.look(until_ns)
    assert rig.read(0.001, 3) == [None] * 3
    assert rig.tally.late_frames == 3
