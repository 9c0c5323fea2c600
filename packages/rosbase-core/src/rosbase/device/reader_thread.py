"""The thread that reads a device as long as it is wanted, and reopens it when it is lost."""

import select
import threading

from rosbase.contracts.stamper import Stamper
from rosbase.contracts.transport import OnFrame, Tally, TransportContext
from rosbase.device.device import Device, OpenDevice, give_back
from rosbase.device.intake import Intake
from rosbase.device.watch import Watch
from rosbase.errors import TransportError
from rosbase.framing import Framer
from rosbase.runtime.backoff import Backoff
from rosbase.runtime.signal_masks import background_thread
from rosbase.runtime.wake_pipe import WakePipe

__all__ = ["ReaderThread"]

# A fast UART hands over 16 bytes every 50 us, and waking up for each of them would cost a
# quarter of a core at 3 Mbaud. Where small pieces come in such a hurry, they are left to
# gather for a moment; up to some 2,000 pieces a second are read as they come.
_HURRIED_NS = 500_000
_SMALL_BYTES = 512
_GATHER_S = 0.001
# How often whoever waits for data looks and sees that there is none.
_LOOK_MS, _NS_PER_MS = 500.0, 1_000_000


class ReaderThread:
    """Reads frames and hands them over; reopens a lost device, until it is stopped.

    It owns the device while it runs, so no other thread closes it during a read.
    """

    def __init__(
        self,
        open_device: OpenDevice,
        context: TransportContext,
        framer: Framer | None,
        device: Device | None,
        on_frame: OnFrame,
        tally: Tally,
        stamper: Stamper,
        watch: Watch,
    ) -> None:
        """Prepare to read `device`, or to wait for one."""
        self._open_device = open_device
        self._context = context
        self._is_stream = framer is not None
        self._stamper = stamper
        self._intake = Intake(framer, on_frame, context, tally, stamper)
        self._tally = tally
        self._watch = watch
        self._backoff = Backoff()
        self._stopping = False
        self._wakeup = WakePipe()
        # Guards what others and the ending thread both decide: who closes the device.
        self._end_lock = threading.Lock()
        self._has_ended = False
        self._closes_device = False
        self.device = device
        """Device, as long as there is one; the thread that joins this one takes it over."""
        self._has_lost_device = False
        self._thread = background_thread(self._run, "rosbase-reader")

    def start(self) -> None:
        """Start reading data that arrives from now on.

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
        """Whether the caller runs on this thread, which means within `on_frame`."""
        return threading.current_thread() is self._thread

    @property
    def is_stopping(self) -> bool:
        """Whether the thread has ended or was asked to."""
        return self._stopping or self._has_ended

    def request_stop(self) -> None:
        """Ask the thread to end. It does so after the frame that it is handing over."""
        self._stopping = self._intake.is_ended = True
        self._wakeup.wake()

    def close_device_at_end(self) -> None:
        """Ask the thread to close its device at its end; close the device now if it has ended."""
        with self._end_lock:
            self._closes_device = True
            if self._has_ended:
                self._close_device()

    def join(self, timeout_s: float) -> bool:
        """Wait for the end; return whether it came in time."""
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
        """Read until the device is lost or the thread must end."""
        intake, stamper = self._intake, self._stamper
        intake.begin(device)
        fd = device.fileno()
        readable = select.poll()
        readable.register(fd, select.POLLIN)
        readable.register(self._wakeup, select.POLLIN)
        monotonic_ns = self._context.clock.monotonic_ns
        watch = self._watch
        watch.begin(device)
        look_ms = min(_LOOK_MS, watch.timeout_ms or _LOOK_MS)

        def read_within(timeout_ms: float) -> bytes:
            ready = readable.poll(timeout_ms)
            if len(ready) != 1 or ready[0][0] != fd:
                return b""
            data = device.read()
            if not data:
                # Somebody else was faster, and may be so again and again.
                self._sleep(_GATHER_S)
            return data

        try:
            while not self._stopping:
                asked_ns = monotonic_ns()
                if asked_ns >= watch.due_ns and not watch.look(asked_ns):
                    # It is there, and silent. How often it is opened is the watch's to limit.
                    self._has_lost_device = True
                    self._backoff.reset()
                    self._close_device()
                    return
                data = read_within(look_ms)
                if not data:
                    stamper.look(asked_ns + int(look_ms * _NS_PER_MS))
                    continue
                # Only data proves that a device works: some open and fail again and again.
                self._backoff.reset()
                read_ns = intake.take(data, read_within)
                is_small = self._is_stream and len(data) < _SMALL_BYTES
                if read_ns - asked_ns < _HURRIED_NS and is_small:
                    self._sleep(_GATHER_S)
        except TransportError as error:
            self._has_lost_device = True
            # Before the state says that the device is gone: who sees that may ask why.
            self._say(error)
            self._close_device()

    def _reopen(self) -> Device | None:
        """Return the device when it is back; None if the thread must end first."""
        logger = self._context.logger
        while not self._sleep(self._backoff.next_s()):
            try:
                self.device = device = self._open_device()
            except TransportError as error:
                self._say(error)
            else:
                self._discard_input(device)
                self._tally.reconnects += self._has_lost_device
                # Of one that was there and silent, only data tells.
                if not self._watch.is_silent:
                    self._tally.last_error = ""
                    logger.info(f"{device.name} is {'back' if self._has_lost_device else 'there'}")
                return device
        return None

    def _discard_input(self, device: Device) -> None:
        try:
            device.discard_input()
        except TransportError:
            # It has been lost, and the thread will find out.
            pass
        self._stamper.begin()

    def _sleep(self, seconds: float) -> bool:
        """Wait; return True at once if the thread must end."""
        wakeup = select.poll()
        wakeup.register(self._wakeup, select.POLLIN)
        wakeup.poll(seconds * 1000.0)
        return self._stopping

    def _close_device(self) -> None:
        device, self.device = self.device, None
        if device is not None:
            give_back(device, self._context.logger)

    def _say(self, error: TransportError) -> None:
        """Log why there is no device, once for each reason in a row."""
        self._watch.is_silent = False
        if str(error) != self._tally.last_error:
            self._tally.last_error = str(error)
            self._context.logger.warning(f"{error}; trying again")
