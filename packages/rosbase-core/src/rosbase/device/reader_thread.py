"""The thread that reads a device for as long as it is wanted, whatever becomes of the device."""

import select
import threading

from rosbase.contracts.transport import OnFrame, Tally, TransportContext, hand_over
from rosbase.device.device import Device, OpenDevice, give_back
from rosbase.errors import TransportError
from rosbase.framing import Frame, Framer
from rosbase.runtime.backoff import Backoff
from rosbase.runtime.wake_pipe import WakePipe

__all__ = ["ReaderThread"]

# A fast UART hands over 16 bytes every 50 us, and waking up for each of them would cost a
# quarter of a core at 3 Mbaud. Where small pieces come in such a hurry, they are left to
# gather for a moment; up to some 2,000 pieces a second are read as they come.
_HURRIED_NS = 500_000
_SMALL_BYTES = 512
_GATHER_S = 0.001


class ReaderThread:
    """Reads, frames and hands over; reopens the device when it is lost, until it is stopped.

    It owns the device while it runs, so nobody else closes it under a read.
    """

    def __init__(
        self,
        open_device: OpenDevice,
        context: TransportContext,
        framer: Framer | None,
        device: Device | None,
        on_frame: OnFrame,
        tally: Tally,
    ) -> None:
        """Prepares to read `device`, or to wait for one."""
        self._open_device = open_device
        self._context = context
        self._framer = framer
        self._on_frame = on_frame
        self._tally = tally
        self._backoff = Backoff()
        self._stopping = False
        self._wakeup = WakePipe()
        # Guards what others and the ending thread both decide: who closes the device.
        self._end_lock = threading.Lock()
        self._has_ended = False
        self._closes_device = False
        self.device = device
        """The device as long as there is one; whoever joins the thread takes it over."""
        self._has_lost_device = False
        self._thread = threading.Thread(target=self._run, name="rosbase-reader", daemon=True)

    def start(self) -> None:
        """Begins, from what arrives from now on.

        Raises:
            RuntimeError: The system has no more threads.
        """
        try:
            # Not on the thread, which would discard what comes after `start` has returned.
            if self.device is not None:
                self._discard_input(self.device)
            self._thread.start()
        except BaseException:
            self._wakeup.close()
            raise

    @property
    def is_current_thread(self) -> bool:
        """Whether the caller runs on this thread, which is to say within `on_frame`."""
        return threading.current_thread() is self._thread

    @property
    def is_stopping(self) -> bool:
        """Whether the thread has ended or been asked to."""
        return self._stopping or self._has_ended

    def request_stop(self) -> None:
        """Asks the thread to end. It does so after the frame that it is handing over."""
        self._stopping = True
        self._wakeup.wake()

    def close_device_at_end(self) -> None:
        """Has the thread close its device as the last thing it does, or closes it if that was."""
        with self._end_lock:
            self._closes_device = True
            if self._has_ended:
                self._close_device()

    def join(self, timeout_s: float) -> bool:
        """Waits for the end; tells whether it came in time."""
        self._thread.join(timeout_s)
        return not self._thread.is_alive()

    def _run(self) -> None:
        try:
            while not self._stopping:
                device = self.device or self._reopen()
                if device is not None:
                    self._read(device)
        except BaseException as error:
            self._tally.last_error = f"the reader failed: {error!r}"
            self._context.logger.error(self._tally.last_error, exc_info=error)
            self._closes_device = True
        finally:
            with self._end_lock:
                self._has_ended = True
                self._wakeup.close()
                if self._closes_device:
                    self._close_device()

    def _read(self, device: Device) -> None:
        """Reads until the device is lost or the thread is to end."""
        if self._framer is not None:
            self._framer.reset()
        fd = device.fileno()
        readable = select.poll()
        readable.register(fd, select.POLLIN)
        readable.register(self._wakeup, select.POLLIN)
        monotonic_ns = self._context.clock.monotonic_ns
        try:
            while not self._stopping:
                asked_ns = monotonic_ns()
                ready = readable.poll()
                data = device.read() if len(ready) == 1 and ready[0][0] == fd else b""
                if data:
                    waited_ns = monotonic_ns() - asked_ns
                    self._take(data)
                    is_small = self._framer is not None and len(data) < _SMALL_BYTES
                    if waited_ns < _HURRIED_NS and is_small:
                        self._sleep(_GATHER_S)
        except TransportError as error:
            self._has_lost_device = True
            # Before the state says that the device is gone: who sees that may ask why.
            self._say(error)
            self._close_device()

    def _take(self, data: bytes) -> None:
        """Hands over the frames that the data completes."""
        context, tally = self._context, self._tally
        stamp_ns = context.clock.now_ns()
        tally.last_data_ns = context.clock.monotonic_ns()
        tally.received_bytes += len(data)
        # Only data proves that a device works: some open and fail again and again.
        self._backoff.reset()
        framer = self._framer
        for event in [Frame(data, stamp_ns)] if framer is None else framer.feed(data, stamp_ns):
            if self._stopping:
                return
            if isinstance(event, Frame):
                tally.frames += 1
                hand_over(self._on_frame, event.data, event.stamp_ns, context.logger)
            else:
                tally.count_error(event.reason)

    def _reopen(self) -> Device | None:
        """The device, when it is there again; None if the thread is to end first."""
        logger = self._context.logger
        while not self._sleep(self._backoff.next_s()):
            try:
                self.device = device = self._open_device()
            except TransportError as error:
                self._say(error)
            else:
                self._discard_input(device)
                self._tally.reconnects += self._has_lost_device
                self._tally.last_error = ""
                logger.info(f"{device.name} is {'back' if self._has_lost_device else 'there'}")
                return device
        return None

    @staticmethod
    def _discard_input(device: Device) -> None:
        try:
            device.discard_input()
        except TransportError:
            # It has been lost, and the thread will find out.
            pass

    def _sleep(self, seconds: float) -> bool:
        """Waits; true at once if the thread is to end."""
        wakeup = select.poll()
        wakeup.register(self._wakeup, select.POLLIN)
        wakeup.poll(seconds * 1000.0)
        return self._stopping

    def _close_device(self) -> None:
        device, self.device = self.device, None
        if device is not None:
            give_back(device, self._context.logger)

    def _say(self, error: TransportError) -> None:
        """Logs why there is no device, once for each reason in a row."""
        if str(error) != self._tally.last_error:
            self._tally.last_error = str(error)
            self._context.logger.warning(f"{error}; trying again")
