"""Mutants that keep what they take."""

import os
import threading
import time

from rosbase.contracts.transport import OnFrame, Transport, TransportState
from rosbase.device import Device
from rosbase.errors import DeviceBusyError, TransportError
from rosbase.framing import FrameEvent, LineFramer
from support.fifo import FifoDevice, make_transport
from support.mutants.losses import Opened
from support.mutants.mutant import LEAKED, RELEASE, Wrapped, mutant, wait_for_release


def leak_a_descriptor() -> None:
    LEAKED.append(os.open(os.devnull, os.O_RDONLY))


@mutant("close-ends-its-threads", "the end of threads after close")
class LeavesAThread(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        threading.Thread(target=wait_for_release).start()
        self.inner.start(on_frame)


@mutant("close-gives-descriptors-back", "descriptors after 2 times to be")
class LeavesADescriptor(Wrapped):
    def close(self) -> None:
        if self.inner.is_open:
            leak_a_descriptor()
        self.inner.close()


@mutant("close-gives-the-device-back", "raised DeviceBusyError")
class KeepsTheDevice(Wrapped):
    def prepare(self) -> None:
        self.lock = f"{self.values['fifo_path']}.lock"

    def start(self, on_frame: OnFrame) -> None:
        try:
            os.close(os.open(self.lock, os.O_CREAT | os.O_EXCL))
        except FileExistsError:
            raise DeviceBusyError(f"{self.lock} is there") from None
        self.inner.start(on_frame)


@mutant("an-on-frame-that-hung-leaves-nothing-behind", "the end of the thread that was left")
class IsStuckForGood(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> None:
            on_frame(frame, stamp_ns)
            wait_for_release()

        self.inner.start(deliver)

    def close(self) -> None:
        threading.Thread(target=self.inner.close).start()


@mutant("a-failed-open-leaks-nothing", "no more descriptors after failed opens")
class LeavesADescriptorOfAFailure(Opened):
    def open_device(self, path: str) -> Device:
        try:
            return FifoDevice(path)
        except TransportError:
            leak_a_descriptor()
            raise


@mutant("a-reconnect-leaks-nothing", "threads and descriptors after one, two and three losses")
class LeavesADescriptorOfEachLoss(Opened):
    def open_device(self, path: str) -> Device:
        device = FifoDevice(path)
        leak_a_descriptor()
        return device


class WithoutALimit(LineFramer):
    def __init__(self) -> None:
        super().__init__(1_000_000_000)


@mutant("memory-is-bounded-without-an-end-of-frame", "without an end")
class GrowsWithoutALimit(Wrapped):
    def make(self) -> Transport:
        return make_transport(self.values, self.context, framer=WithoutALimit())


class LeavesSomething(Wrapped):
    """Leaves a thread, or a descriptor, in one of the ways to the end."""

    def leave(self) -> None:
        raise NotImplementedError


class AThread(LeavesSomething):
    def leave(self) -> None:
        threading.Thread(target=wait_for_release).start()


class ADescriptor(LeavesSomething):
    def leave(self) -> None:
        leak_a_descriptor()


class OfEachStop(LeavesSomething):
    def stop(self) -> None:
        if self.inner.is_open:
            self.leave()
        self.inner.stop()


class OfAnOpenWithoutStart(LeavesSomething):
    is_only_open = False

    def open(self) -> None:
        self.is_only_open = not self.inner.is_open
        self.inner.open()

    def start(self, on_frame: OnFrame) -> None:
        self.is_only_open = False
        self.inner.start(on_frame)

    def close(self) -> None:
        if self.is_only_open:
            self.leave()
        self.is_only_open = False
        self.inner.close()


class OfACloseFromWithin(LeavesSomething):
    reader: threading.Thread | None = None

    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> None:
            self.reader = threading.current_thread()
            on_frame(frame, stamp_ns)

        self.inner.start(deliver)

    def close(self) -> None:
        if threading.current_thread() is self.reader:
            self.leave()
        self.inner.close()


class OfACloseWithoutDevice(LeavesSomething):
    def close(self) -> None:
        if self.inner.health.state is TransportState.RECONNECTING:
            self.leave()
        self.inner.close()


@mutant("close-ends-its-threads", "it was stopped")
class LeavesAThreadOfEachStop(AThread, OfEachStop):
    pass


@mutant("close-gives-descriptors-back", "it was stopped")
class LeavesADescriptorOfEachStop(ADescriptor, OfEachStop):
    pass


@mutant("close-ends-its-threads", "it was open, and not started")
class LeavesAThreadOfAnOpen(AThread, OfAnOpenWithoutStart):
    pass


@mutant("close-gives-descriptors-back", "it was open, and not started")
class LeavesADescriptorOfAnOpen(ADescriptor, OfAnOpenWithoutStart):
    pass


@mutant("close-ends-its-threads", "it was closed from within on_frame")
class LeavesAThreadOfACloseFromWithin(AThread, OfACloseFromWithin):
    pass


@mutant("close-gives-descriptors-back", "it was closed from within on_frame")
class LeavesADescriptorOfACloseFromWithin(ADescriptor, OfACloseFromWithin):
    pass


@mutant("close-ends-its-threads", "it was without its device")
class LeavesAThreadOfACloseWithoutDevice(AThread, OfACloseWithoutDevice):
    pass


@mutant("close-gives-descriptors-back", "it was without its device")
class LeavesADescriptorOfACloseWithoutDevice(ADescriptor, OfACloseWithoutDevice):
    pass


@mutant("close-ends-its-threads", "the end of threads after close")
class LetsAThreadLinger(Wrapped):
    def close(self) -> None:
        if self.inner.is_open:
            threading.Timer(1.5, self.inner.close).start()
        self.inner.close()


@mutant("memory-is-bounded-while-it-reads", "bytes that were read")
class KeepsEveryFrame(Wrapped):
    def prepare(self) -> None:
        self.kept: list[bytes] = []

    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> None:
            self.kept.append(frame)
            on_frame(frame, stamp_ns)

        self.inner.start(deliver)


class KeepsWhatIsBad(LineFramer):
    def __init__(self) -> None:
        super().__init__()
        self.kept: list[bytes] = []

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events = super().feed(data, stamp_ns)
        if data.startswith(b"xxx"):
            self.kept.append(data)
        return events


@mutant("memory-is-bounded-while-it-reads", "bytes that were read")
class KeepsEveryBadFrame(Wrapped):
    def make(self) -> Transport:
        return make_transport(self.values, self.context, framer=KeepsWhatIsBad())


class Turns(Wrapped):
    """Has a thread that never rests, while it is so."""

    spinner: threading.Thread | None = None
    is_wanted = False

    def start(self, on_frame: OnFrame) -> None:
        self.inner.start(on_frame)
        if self.spinner is None or not self.spinner.is_alive():
            self.is_wanted = True
            self.spinner = threading.Thread(target=self.spin)
            self.spinner.start()

    def close(self) -> None:
        self.is_wanted = False
        self.inner.close()

    def spin(self) -> None:
        while self.is_wanted and not RELEASE.is_set():
            if not self.turns():
                RELEASE.wait(0.01)

    def turns(self) -> bool:
        raise NotImplementedError


@mutant("waiting-costs-no-processor", "while nothing arrived")
class TurnsWhileNothingArrives(Turns):
    def turns(self) -> bool:
        return True


@mutant("waiting-costs-no-processor", "while the device was away")
class TurnsWhileTheDeviceIsAway(Turns):
    def turns(self) -> bool:
        return self.inner.health.state is TransportState.RECONNECTING


@mutant("waiting-costs-no-processor", "while the device was away")
class TurnsOnABusyMachine(TurnsWhileTheDeviceIsAway):
    """Gets less than half of a processor, because others want it too."""

    def turns(self) -> bool:
        return super().turns() and time.thread_time() < 0.16


@mutant("close-gives-descriptors-back", "it was without its device")
class TakesTheDeviceAfterClose(Wrapped):
    def close(self) -> None:
        is_away = self.inner.health.state is TransportState.RECONNECTING
        self.inner.close()
        if is_away:
            threading.Thread(target=self.wait_for_device).start()

    def wait_for_device(self) -> None:
        while not RELEASE.wait(0.1):
            try:
                LEAKED.append(FifoDevice(str(self.values["fifo_path"])).fileno())
            except TransportError:
                continue
            return
