"""Mutants that keep what they take."""

import os
import threading

from rosbase.device import Device
from rosbase.errors import DeviceBusyError, TransportError
from rosbase.framing import LineFramer
from rosbase.transport import OnFrame, Transport
from support.fifo import FifoDevice, make_transport
from support.mutants.losses import Opened
from support.mutants.mutant import LEAKED, Wrapped, mutant, wait_for_release


def leak_a_descriptor() -> None:
    LEAKED.append(os.open(os.devnull, os.O_RDONLY))


@mutant("close-ends-its-threads", "the end of threads after close")
class LeavesAThread(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        threading.Thread(target=wait_for_release).start()
        self.inner.start(on_frame)


@mutant("close-gives-descriptors-back", "descriptors after 5 times open and close")
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
