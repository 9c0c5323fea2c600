"""Mutants that cannot live without their device."""

import threading

from attrs import evolve

from rosbase.contracts.transport import OnFrame, Transport, TransportHealth, TransportState
from rosbase.device import Device, DeviceTransport
from rosbase.errors import DeviceNotFoundError, TransportError
from rosbase.framing import FrameEvent, LineFramer
from rosbase.logger import RosbaseLogger
from support.fifo import FifoDevice, make_transport
from support.mutants.mutant import Wrapped, mutant


class Opened(Wrapped):
    """Opens its device in a way of its own."""

    def make(self) -> Transport:
        return DeviceTransport(
            lambda: self.open_device(str(self.values["fifo_path"])),
            self.context,
            framer=LineFramer(),
            waits_for_device=bool(self.values["wait"]),
            reopen_after_s=float(str(self.values.get("silence", 0.0))),
        )

    def open_device(self, path: str) -> Device:
        return FifoDevice(path)


@mutant("an-absent-device-is-refused-in-one-line", "open() succeeded without a device")
class OpensWithoutADevice(Wrapped):
    def open(self) -> None:
        try:
            self.inner.open()
        except TransportError:
            self.context.logger.warning("there is no device")


@mutant("an-absent-device-is-refused-in-one-line", "which names none of")
class DoesNotNameTheDevice(Opened):
    def open_device(self, path: str) -> Device:
        try:
            return FifoDevice(path)
        except DeviceNotFoundError:
            raise DeviceNotFoundError("cannot open the device") from None


@mutant("an-absent-device-is-refused-in-one-line", "several lines")
class RefusesInManyLines(Opened):
    def open_device(self, path: str) -> Device:
        try:
            return FifoDevice(path)
        except DeviceNotFoundError as error:
            raise DeviceNotFoundError(f"{error}\nhave you plugged it in?") from error


@mutant("an-absent-device-is-refused-in-one-line", "open() raised FileNotFoundError")
class RaisesWhatTheSystemDoes(Opened):
    def open_device(self, path: str) -> Device:
        with open(path):
            return FifoDevice(path)


@mutant("open-may-be-tried-again", "open() raised")
class RemembersItsFailure(Opened):
    failure: TransportError | None = None

    def open_device(self, path: str) -> Device:
        if self.failure is not None:
            raise self.failure
        try:
            return FifoDevice(path)
        except TransportError as error:
            self.failure = error
            raise


@mutant("an-absent-device-is-waited-for", "open() raised")
class DoesNotWait(Wrapped):
    def make(self) -> Transport:
        return make_transport({**self.values, "wait": False}, self.context)


@mutant("an-absent-device-is-waited-for", "it came late, it did not come back")
class CountsTheFirstTime(Wrapped):
    @property
    def health(self) -> TransportHealth:
        return evolve(self.inner.health, reconnects=1)


@mutant("a-loss-is-noticed", "health.state to be RECONNECTING")
class DoesNotNoticeALoss(Wrapped):
    @property
    def health(self) -> TransportHealth:
        return evolve(self.inner.health, state=TransportState.CONNECTED)


@mutant("a-loss-is-noticed", "last_error was empty")
class DoesNotSayWhy(Wrapped):
    @property
    def health(self) -> TransportHealth:
        return evolve(self.inner.health, last_error="")


@mutant("data-flows-again-after-a-loss", "no data 0.8 s after the device was back")
class OpensItsDeviceOnce(Opened):
    is_made = False

    def open_device(self, path: str) -> Device:
        if self.is_made:
            raise DeviceNotFoundError(f"{path} was lost")
        self.is_made = True
        return FifoDevice(path)


@mutant("reconnects-are-counted", "it was 0 after 1 times")
class CountsNoReconnects(Wrapped):
    @property
    def health(self) -> TransportHealth:
        return evolve(self.inner.health, reconnects=0)


class NeverForgets:
    """A framer to which a new beginning means nothing."""

    def __init__(self) -> None:
        self._inner = LineFramer()

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return self._inner.feed(data, stamp_ns)

    def reset(self) -> None:
        pass


@mutant("a-frame-begun-before-a-loss-is-not-continued", "which nobody sent")
class ContinuesAfterALoss(Wrapped):
    def make(self) -> Transport:
        return make_transport(self.values, self.context, framer=NeverForgets())


@mutant("a-loss-is-a-few-lines-in-the-log", "3 losses made")
class LogsEveryTry(Opened):
    def open_device(self, path: str) -> Device:
        for step in ("looking for it", "opening it", "setting it up", "done"):
            self.context.logger.warning(f"{path}: {step}")
        return FifoDevice(path)


@mutant("a-loss-is-a-few-lines-in-the-log", "was not logged at all")
class LogsNoLoss(Wrapped):
    def make(self) -> Transport:
        return make_transport(self.values, evolve(self.context, logger=RosbaseLogger("elsewhere")))


@mutant("an-absent-device-is-refused-in-one-line", "open() succeeded without a device")
class OpensTheSecondTime(Wrapped):
    has_failed = False

    def open(self) -> None:
        try:
            self.inner.open()
        except TransportError:
            if not self.has_failed:
                self.has_failed = True
                raise


@mutant("data-flows-again-after-a-loss", "threads called on_frame after losses")
class HasANewThreadAfterALoss(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> None:
            thread = threading.Thread(target=on_frame, args=(frame, stamp_ns))
            if self.inner.health.reconnects:
                thread.start()
                thread.join()
            else:
                on_frame(frame, stamp_ns)

        self.inner.start(deliver)


@mutant("data-flows-again-after-a-loss", "since the device was back frames came twice")
class HandsOverTwiceAfterALoss(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> None:
            on_frame(frame, stamp_ns)
            if self.inner.health.reconnects:
                on_frame(frame, stamp_ns)

        self.inner.start(deliver)


@mutant("reconnects-are-counted", "it was 0 after 3 times and close")
class CountsReconnectsSinceTheLastClose(Wrapped):
    before = 0

    def close(self) -> None:
        self.inner.close()
        self.before = self.inner.health.reconnects

    @property
    def health(self) -> TransportHealth:
        return evolve(self.inner.health, reconnects=self.inner.health.reconnects - self.before)


@mutant("an-absent-device-is-refused-in-one-line", "health.last_error has several lines")
class KeepsSeveralLines(Wrapped):
    @property
    def health(self) -> TransportHealth:
        health = self.inner.health
        return evolve(health, last_error=f"{health.last_error}\nand more")


@mutant("a-silent-device-is-opened-anew", "health.reconnects to reach 2")
class HasPatienceForEver(Wrapped):
    def make(self) -> Transport:
        return make_transport({**self.values, "silence": 0.0}, self.context)


@mutant("a-silent-device-is-opened-anew", "health.last_error was empty")
class DoesNotSayThatItIsSilent(Wrapped):
    @property
    def health(self) -> TransportHealth:
        return evolve(self.inner.health, last_error="")


@mutant("a-silent-device-is-opened-anew", "no data 0.8 s after the device was back")
class DoesNotReadWhatItHasOpenedAnew(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        self.inner.start(lambda *frame: None if self.inner.health.reconnects else on_frame(*frame))


@mutant("a-silent-device-is-opened-anew", "health.last_error to be empty again")
class SaysForEverThatItIsSilent(Wrapped):
    @property
    def health(self) -> TransportHealth:
        health = self.inner.health
        return evolve(health, last_error=health.last_error or "silent" * bool(health.reconnects))


@mutant("a-silent-device-is-opened-anew", "times or more made")
class SaysEachTimeThatItIsSilent(Opened):
    def open_device(self, path: str) -> Device:
        self.context.logger.warning(f"{path} is silent")
        return FifoDevice(path)


@mutant("a-silent-device-is-opened-anew", "was not logged at all")
class SaysNothingOfASilentDevice(Wrapped):
    def make(self) -> Transport:
        return make_transport(self.values, evolve(self.context, logger=RosbaseLogger("elsewhere")))
