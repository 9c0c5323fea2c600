"""What is looked at while a device is read: whether it sends, and what it reports itself."""

from collections.abc import Callable
from pathlib import Path

import pytest

from rosbase.contracts.transport import Tally, TransportContext, TransportState
from rosbase.device import DeviceReport
from rosbase.device.watch import Watch
from rosbase.errors import TransportError
from rosbase.logger import RosbaseLogger
from rosbase.testing import ManualClock, RecordingSubscriber
from support.fifo import FifoDevice, FifoPeer, make_transport
from support.waiting import wait_until


class Silent:
    """A device of which only the name counts."""

    name = "the device"

    def fileno(self) -> int:
        return -1

    def read(self) -> bytes:
        return b""

    def discard_input(self) -> None:
        pass

    def close(self) -> None:
        pass


class Reporting(Silent):
    """Reports what the test says."""

    def __init__(self, *reports: DeviceReport) -> None:
        self.reports = list(reports)
        self.asked: list[bool] = []

    def report(self, is_quiet: bool) -> DeviceReport:
        self.asked.append(is_quiet)
        return self.reports.pop(0) if self.reports else DeviceReport()


class Rig:
    """A watch on a clock that stands still until it is turned."""

    def __init__(self, reopen_after_s: float = 0.0) -> None:
        self.clock = ManualClock()
        self.tally = Tally()
        context = TransportContext(self.clock, RosbaseLogger("watch", clock=self.clock))
        self.watch = Watch(context, self.tally, reopen_after_s)

    def hear(self, data: bytes = b"x") -> None:
        self.tally.received_bytes += len(data)
        self.tally.last_data_ns = self.clock.monotonic_ns()

    def looks(self, after_s: float = 1.0) -> bool:
        self.clock.advance(after_s)
        return self.watch.look(self.clock.monotonic_ns())

    def reopens_after(self) -> int:
        """How many seconds pass until the device is to be opened anew."""
        self.watch.begin(Silent())
        return next(second for second in range(1, 1_000) if not self.looks())


def test_a_read_costs_nothing_where_there_is_nothing_to_look_at() -> None:
    rig = Rig()
    rig.watch.begin(Silent())
    assert rig.watch.timeout_ms is None
    assert rig.watch.due_ns > 10**18


@pytest.mark.parametrize(
    ("reopen_after_s", "timeout_ms"), [(0.0, 1_000.0), (0.2, 100.0), (5.0, 1_000.0)]
)
def test_a_look_is_due_once_a_second_or_twice_within_the_limit(
    reopen_after_s: float, timeout_ms: float
) -> None:
    rig = Rig(reopen_after_s)
    rig.watch.begin(Reporting())
    assert rig.watch.timeout_ms == timeout_ms
    assert rig.watch.due_ns == timeout_ms * 1e6
    rig.hear()
    rig.looks(0.15)
    assert rig.watch.due_ns == 0.15e9 + timeout_ms * 1e6


def test_each_time_in_vain_it_has_twice_the_patience_up_to_eight_times() -> None:
    rig = Rig(5.0)
    assert [rig.reopens_after() for _ in range(6)] == [5, 10, 20, 40, 40, 40]
    rig.watch.begin(Silent())
    rig.hear()
    assert rig.looks()
    assert rig.reopens_after() == 5, "it has sent in between"


def test_a_device_that_sends_is_left_alone_and_one_that_falls_silent_is_not() -> None:
    rig = Rig(5.0)
    rig.watch.begin(Silent())
    for _ in range(20):
        rig.hear()
        assert rig.looks(4.0)
    assert not rig.looks(1.0)


def test_silence_is_said_once_and_that_it_is_over(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    rig = Rig(5.0)
    for _ in range(3):
        rig.reopens_after()
        assert rig.tally.last_error == "the device has sent nothing for 5 s"
    assert caplog.messages == ["the device has sent nothing for 5 s; opening it again"]
    rig.watch.begin(Silent())
    assert rig.watch.due_ns == 0, "its first data are noticed at once"
    rig.hear()
    assert rig.looks(0.001)
    assert caplog.messages[1:] == ["the device sends again"]
    assert rig.tally.last_error == ""


def test_what_a_device_reports_is_counted_and_said() -> None:
    rig = Rig()
    device = Reporting(DeviceReport(errors={"overrun": 3}), DeviceReport(errors={"overrun": 2}))
    rig.watch.begin(device)
    rig.hear()
    assert all(rig.looks() for _ in range(3))
    assert rig.tally.link_errors == {"overrun": 5}
    assert device.asked == [False, True, True]


def test_a_remark_is_logged_at_a_limited_rate(caplog: pytest.LogCaptureFixture) -> None:
    rig = Rig()
    rig.watch.begin(Reporting(*[DeviceReport(remark="3 characters lost")] * 12))
    for _ in range(12):
        rig.looks()
    assert caplog.messages == ["3 characters lost"] * 3


def test_a_trouble_is_said_when_it_changes_and_stands_in_health(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level("INFO")
    rig = Rig()
    reports = [DeviceReport("A reads it too")] * 5 + [DeviceReport("B reads it too")] * 5
    rig.watch.begin(Reporting(*reports))
    seen = []
    for _ in range(12):
        rig.looks()
        seen.append(rig.tally.last_error)
    assert seen == ["A reads it too"] * 5 + ["B reads it too"] * 5 + [""] * 2
    assert caplog.messages == ["A reads it too", "B reads it too", "resolved: B reads it too"]


def test_a_trouble_of_the_reader_before_is_forgotten_with_it() -> None:
    rig = Rig()
    rig.watch.begin(Reporting(DeviceReport("A reads it too")))
    rig.looks()
    rig.watch.begin(Reporting())
    assert rig.tally.last_error == ""


def test_silence_and_a_trouble_together_leave_the_word_to_the_trouble() -> None:
    rig = Rig(2.0)
    rig.watch.begin(Reporting(*[DeviceReport("A reads it too")] * 2))
    assert [rig.looks() for _ in range(2)] == [True, False]
    assert rig.tally.last_error == "A reads it too"
    rig.watch.begin(Reporting())
    rig.looks()
    assert rig.tally.last_error == "the device has sent nothing for 2 s"


def test_a_trouble_that_lasts_over_many_silences_is_said_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    rig = Rig(1.0)
    for _ in range(5):
        rig.watch.begin(Reporting(*[DeviceReport("A reads it too")] * 20))
        while rig.looks():
            pass
    assert caplog.messages == [
        "A reads it too",
        "the device has sent nothing for 1 s; opening it again",
    ]
    assert rig.tally.last_error == "A reads it too"


class ReportingFifo(FifoDevice):
    """A named pipe that reports what the test says."""

    next_report: Callable[[], DeviceReport] = DeviceReport

    def report(self, is_quiet: bool) -> DeviceReport:
        return type(self).next_report()


def test_a_device_that_is_read_is_asked_for_its_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    peer, subscriber = FifoPeer(tmp_path), RecordingSubscriber()
    report = DeviceReport("somebody reads it too", {"overrun": 1})
    monkeypatch.setattr(ReportingFifo, "next_report", lambda: report)
    context = TransportContext(ManualClockThatRuns(), RosbaseLogger("watch"))
    transport = make_transport({**peer.parameters, "wait": False}, context, device=ReportingFifo)
    transport.start(subscriber)
    wait_until(lambda: transport.health.last_error, "the report")
    health = transport.health
    assert (health.state, health.last_error) == (TransportState.CONNECTED, "somebody reads it too")
    assert health.link_errors["overrun"] >= 1
    peer.send(b"goes on")
    assert subscriber.wait_for(1)

    def lost() -> DeviceReport:
        raise TransportError("its firmware has crashed")

    monkeypatch.setattr(ReportingFifo, "next_report", lost)
    wait_until(lambda: transport.health.reconnects, "the loss that it reports, and its return")
    transport.close()
    peer.close()


class ManualClockThatRuns(ManualClock):
    """Each look at it is half a second later, so that everything is due soon."""

    def monotonic_ns(self) -> int:
        self.advance(0.5)
        return super().monotonic_ns()
