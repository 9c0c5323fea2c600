"""The thread that reads a port for as long as it is wanted, whatever becomes of the port."""

import os
import select
import threading

from imu_serial.config import SerialConfig
from imu_serial.port import Port
from rosbase.backoff import Backoff
from rosbase.errors import TransportError
from rosbase.framing import Frame, LineFramer
from rosbase.transport import OnFrame, Tally, TransportContext

__all__ = ["ReaderThread"]

_CALLBACK_LOG_S = 5.0

# A fast UART hands over 16 bytes every 50 us, and waking up for each of them would cost a
# quarter of a core at 3 Mbaud. Where small pieces come in such a hurry, they are left to
# gather for a moment; up to some 2,000 pieces a second are read as they come.
_HURRIED_NS = 500_000
_SMALL_BYTES = 512
_GATHER_S = 0.001


class ReaderThread:
    """Reads, frames and hands over; reopens the port when it is lost, until it is stopped.

    It owns the port while it runs, so nobody else closes it under a read.
    """

    def __init__(
        self,
        config: SerialConfig,
        context: TransportContext,
        port: Port | None,
        on_frame: OnFrame,
        tally: Tally,
    ) -> None:
        """Prepares to read `port`, or to wait for one."""
        self._config = config
        self._context = context
        self._on_frame = on_frame
        self._tally = tally
        self._framer = LineFramer()
        self._backoff = Backoff()
        self._stopping = False
        # A byte in the pipe wakes the thread wherever it waits in the kernel.
        self._wake_read, self._wake_write = os.pipe()
        # Guards what others and the ending thread both touch: the pipe and who closes the port.
        self._end_lock = threading.Lock()
        self._has_ended = False
        self._closes_port = False
        self.port = port
        """The port as long as there is one; whoever joins the thread takes it over."""
        self._has_lost_port = False
        self._thread = threading.Thread(target=self._run, name="imu-serial", daemon=True)

    def start(self) -> None:
        """Begins."""
        try:
            self._thread.start()
        except RuntimeError:
            os.close(self._wake_read)
            os.close(self._wake_write)
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
        with self._end_lock:
            if not (self._stopping or self._has_ended):
                os.write(self._wake_write, b"x")
            self._stopping = True

    def close_port_at_end(self) -> None:
        """Has the thread close its port as the last thing it does, or closes it if it has ended."""
        with self._end_lock:
            self._closes_port = True
            if self._has_ended:
                self._close_port()

    def join(self, timeout_s: float) -> bool:
        """Waits for the end; tells whether it came in time."""
        self._thread.join(timeout_s)
        return not self._thread.is_alive()

    def _run(self) -> None:
        try:
            while not self._stopping:
                port = self.port or self._reopen()
                if port is not None:
                    self._read(port)
        except BaseException as error:
            self._tally.last_error = f"the reader failed: {error!r}"
            self._context.logger.error(self._tally.last_error, exc_info=error)
            self._closes_port = True
        finally:
            with self._end_lock:
                self._has_ended = True
                os.close(self._wake_read)
                os.close(self._wake_write)
                if self._closes_port:
                    self._close_port()

    def _read(self, port: Port) -> None:
        """Reads until the port is lost or the thread is to end."""
        self._framer.reset()
        port.watch(self._wake_read)
        monotonic_ns = self._context.clock.monotonic_ns
        try:
            port.discard_input()
            while not self._stopping:
                asked_ns = monotonic_ns()
                data = port.read()
                if data:
                    waited_ns = monotonic_ns() - asked_ns
                    self._take(data)
                    if waited_ns < _HURRIED_NS and len(data) < _SMALL_BYTES:
                        self._sleep(_GATHER_S)
        except TransportError as error:
            self._close_port()
            self._has_lost_port = True
            self._say(error)

    def _take(self, data: bytes) -> None:
        """Hands over the frames that the data completes."""
        clock, tally = self._context.clock, self._tally
        stamp_ns = clock.now_ns()
        tally.last_data_ns = clock.monotonic_ns()
        tally.received_bytes += len(data)
        # Only data proves that a port works: some open and fail again and again.
        self._backoff.reset()
        for event in self._framer.feed(data, stamp_ns):
            if self._stopping:
                return
            if isinstance(event, Frame):
                tally.frames += 1
                self._hand_over(event)
            else:
                errors = tally.frame_errors
                errors[event.reason] = errors.get(event.reason, 0) + 1

    def _hand_over(self, frame: Frame) -> None:
        try:
            self._on_frame(frame.data, frame.stamp_ns)
        except BaseException as error:
            # Base: a callback that calls sys.exit() would end this thread only, in silence.
            # The boundary to the user's code: one bad frame must not end the stream.
            logger = self._context.logger
            if logger.due("on_frame", _CALLBACK_LOG_S):
                logger.error(f"on_frame raised {error!r}", exc_info=error)

    def _reopen(self) -> Port | None:
        """The port, when it is there again; None if the thread is to end first."""
        logger = self._context.logger
        while not self._sleep(self._backoff.next_s()):
            try:
                port = Port(self._config)
            except TransportError as error:
                self._say(error)
            else:
                self._tally.reconnects += self._has_lost_port
                self._tally.last_error = ""
                self.port = port
                logger.info(f"{port.name} is {'back' if self._has_lost_port else 'there'}")
                return port
        return None

    def _sleep(self, seconds: float) -> bool:
        """Waits; true at once if the thread is to end."""
        wakeup = select.poll()
        wakeup.register(self._wake_read, select.POLLIN)
        wakeup.poll(seconds * 1000.0)
        return self._stopping

    def _close_port(self) -> None:
        if self.port is not None:
            self.port.close()
            self.port = None

    def _say(self, error: TransportError) -> None:
        """Logs why there is no port, once for each reason in a row."""
        if str(error) != self._tally.last_error:
            self._tally.last_error = str(error)
            self._context.logger.warning(f"{error}; trying again")
