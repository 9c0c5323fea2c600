"""A device that is busy when it is to be opened is given some seconds, as long as nobody ends."""

import threading
from collections.abc import Callable

import pytest

from rosbase.clock import Clock, SystemClock
from rosbase.contracts.transport import TransportContext, TransportState
from rosbase.device import Device, DeviceTransport
from rosbase.errors import (
    DeviceBusyError,
    DeviceNotFoundError,
    DevicePermissionError,
    NotADeviceError,
    TransportError,
)
from rosbase.logger import RosbaseLogger
from rosbase.runtime.wake_pipe import WakePipe
from rosbase.testing import ManualClock, RecordingSubscriber
from support.stopwatch import Stopwatch
from support.waiting import wait_until

BUSY = DeviceBusyError("the port is in use by process 7 (ModemManager)")


class Idle:
    """A device that has nothing to say, at the end of a pipe that nobody writes to."""

    name = "the device"

    def __init__(self) -> None:
        self._pipe = WakePipe()

    def fileno(self) -> int:
        return self._pipe.fileno()

    def read(self) -> bytes:
        return b""

    def discard_input(self) -> None:
        pass

    def close(self) -> None:
        self._pipe.close()


class Opener:
    """Opens the device once it has failed so often."""

    def __init__(self, failures: int, error: TransportError = BUSY) -> None:
        self.failures = failures
        self.error = error
        self.tries = 0
        self.then: Callable[[], None] | None = None

    def __call__(self) -> Device:
        self.tries += 1
        if self.then is not None:
            self.then()
        if self.tries <= self.failures:
            raise self.error
        return Idle()


def transport_of(
    opener: Opener, *, waits: bool = False, clock: Clock | None = None
) -> DeviceTransport:
    context = TransportContext(clock or ManualClock(), RosbaseLogger("patience"))
    return DeviceTransport(opener, context, waits_for_device=waits)


def test_what_is_busy_for_two_seconds_is_opened_and_said_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    clock, opener = ManualClock(), Opener(20)
    transport = transport_of(opener, clock=clock)
    transport.open()
    assert transport.is_open
    assert clock.monotonic_ns() == pytest.approx(2.0e9)
    assert caplog.messages == [f"{BUSY}; trying again for 3 s"]
    assert transport.health.last_error == ""
    transport.close()


def test_what_stays_busy_is_refused_after_three_seconds() -> None:
    clock, opener = ManualClock(), Opener(10_000)
    transport = transport_of(opener, clock=clock)
    with pytest.raises(DeviceBusyError, match="process 7"):
        transport.open()
    assert 3.0e9 <= clock.monotonic_ns() < 3.2e9
    assert transport.health.state is TransportState.CLOSED
    assert transport.health.last_error == str(BUSY)


def test_what_stays_busy_is_waited_for_by_option_and_not_once_more(
    caplog: pytest.LogCaptureFixture,
) -> None:
    clock, opener = ManualClock(), Opener(10_000)
    transport = transport_of(opener, waits=True, clock=clock)
    transport.open()
    assert transport.health.state is TransportState.RECONNECTING
    waited_ns, tries = clock.monotonic_ns(), opener.tries
    transport.open()
    assert (clock.monotonic_ns(), opener.tries) == (waited_ns, tries + 1)
    assert caplog.messages[1:] == [f"{BUSY}; waiting for it"]
    transport.start(RecordingSubscriber())
    opener.failures = 0
    wait_until(lambda: transport.is_open, "the reader thread to open it")
    transport.close()


@pytest.mark.parametrize("kind", [DeviceNotFoundError, DevicePermissionError, NotADeviceError])
def test_what_does_not_pass_soon_is_refused_at_once(kind: type[TransportError]) -> None:
    opener = Opener(10, kind("no"))
    with pytest.raises(kind):
        transport_of(opener).open()
    assert opener.tries == 1


def test_what_becomes_something_else_is_refused_with_that() -> None:
    opener = Opener(10)
    opener.then = lambda: setattr(
        opener, "error", NotADeviceError("no") if opener.tries > 3 else BUSY
    )
    with pytest.raises(NotADeviceError):
        transport_of(opener).open()
    assert opener.tries == 4


@pytest.mark.parametrize("ending", ["stop", "close"])
def test_an_open_that_waits_gives_way_to_whoever_ends(ending: str) -> None:
    transport = transport_of(opener := Opener(10_000), clock=SystemClock())
    refused: list[TransportError] = []

    def open_it() -> None:
        try:
            transport.open()
        except TransportError as error:
            refused.append(error)

    transport.close()
    thread = threading.Thread(target=open_it)
    thread.start()
    wait_until(lambda: opener.tries > 3, "some tries")
    assert thread.is_alive()
    with Stopwatch() as watch:
        getattr(transport, ending)()
        assert watch.took_s < 0.5
    thread.join(10)
    assert [str(error) for error in refused] == [str(BUSY)]
    transport.close()


def test_many_that_end_at_once_are_all_served() -> None:
    transport = transport_of(opener := Opener(10_000), clock=SystemClock(), waits=True)
    threads = [threading.Thread(target=transport.open)]
    threads[0].start()
    wait_until(lambda: opener.tries > 1, "a try")
    threads += [threading.Thread(target=transport.close) for _ in range(8)]
    for thread in threads[1:]:
        thread.start()
    for thread in threads:
        thread.join(2)
        assert not thread.is_alive()
    assert transport.health.state is TransportState.CLOSED
