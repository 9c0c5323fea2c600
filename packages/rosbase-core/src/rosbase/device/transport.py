"""open, start, stop and close, from any thread and in any order, for any device."""

import threading

from rosbase.contracts.stamper import Stamper
from rosbase.contracts.transport import (
    OnFrame,
    Tally,
    Transport,
    TransportContext,
    TransportHealth,
    TransportState,
)
from rosbase.device.device import Device, OpenDevice, give_back
from rosbase.device.patience import Patience
from rosbase.device.reader_thread import ReaderThread
from rosbase.device.watch import Watch
from rosbase.errors import TransportError
from rosbase.framing import Framer

__all__ = ["STOP_TIMEOUT_S", "DeviceTransport"]

STOP_TIMEOUT_S = 2.0
"""Timeout of `stop` for an `on_frame` that does not return."""


class DeviceTransport(Transport):
    """Reads a device with a file descriptor on its own thread, and reopens it when it is lost.

    A plugin makes one from a function that opens its device. Override nothing.
    """

    def __init__(
        self,
        open_device: OpenDevice,
        context: TransportContext,
        *,
        framer: Framer | None = None,
        waits_for_device: bool = False,
        reopen_after_s: float = 0.0,
    ) -> None:
        """Take the arguments; touch no device yet.

        Args:
            open_device: Opens the device. Called on the thread that opens, and later on the reader
                thread, one at a time.
            context: The clock and the logger that the transport was given.
            framer: Splits a stream into frames; None if each read is a whole frame, as with
                datagrams.
            waits_for_device: Whether `open` leaves an absent device to the reader thread, instead
                of raising the error of `open_device`.
            reopen_after_s: Seconds without data after which the device is closed and opened again.
                If that does not help, the time doubles, up to eight times the value. 0: never.
        """
        self._open_device = open_device
        self._context = context
        self._framer = framer
        self._waits_for_device = waits_for_device
        self._reopen_after_s = reopen_after_s
        self._patience = Patience(context)
        self._tally = Tally()
        self._stamper = Stamper(context, self._tally)
        self._device: Device | None = None
        self._reader: ReaderThread | None = None
        self._left_behind: list[ReaderThread] = []
        self._is_awaited = False
        # Serialises the four calls. The reader thread never takes it: it may be joined under it.
        self._lock = threading.RLock()

    def open(self) -> None:
        """Open the device, or leave a device that is waited for to the reader thread.

        If the failure usually passes, such as another program using the device, try for
        some seconds.
        """
        if self._on_reader_thread():
            return
        with self._lock:
            self._collect_stopped_reader()
            if self._reader is not None or self._device is not None:
                return
            try:
                if self._is_awaited:
                    self._device = self._open_device()
                else:
                    self._device = self._patience.open(self._open_device)
            except TransportError as error:
                self._tally.last_error = str(error)
                if not (self._waits_for_device and error.retryable):
                    raise
                if not self._is_awaited:
                    self._context.logger.warning(f"{error}; waiting for it")
                self._is_awaited = True
            else:
                self._tally.last_error = ""
                self._context.logger.info(f"opened {self._device.name}")

    def start(self, on_frame: OnFrame) -> None:
        """Start the reader thread, with the open device or waiting for one."""
        if self._on_reader_thread():
            return
        with self._lock:
            self._collect_stopped_reader()
            if self._reader is not None:
                return
            self.open()
            device = self._device
            try:
                reader = ReaderThread(
                    self._open_device,
                    self._context,
                    self._framer,
                    device,
                    on_frame,
                    self._tally,
                    self._stamper,
                    Watch(self._context, self._tally, self._reopen_after_s),
                )
                # Known before it runs: the first frame may make `on_frame` call us.
                self._reader, self._device = reader, None
                reader.start()
            except BaseException as error:
                self._reader, self._device = None, device
                if isinstance(error, NotImplementedError):
                    # An author's, who has more to do. It is a RuntimeError too.
                    raise
                if isinstance(error, (OSError, RuntimeError)):
                    raise TransportError(f"no reader can be started: {error}") from error
                raise
            self._is_awaited = False

    def stop(self) -> None:
        """End the reader thread; wait for it, except on that thread itself."""
        if self._on_reader_thread():
            self._reader_asks_to_end(closes_device=False)
            return
        with self._patience.ending(), self._lock:
            self._end_reader()

    def close(self) -> None:
        """End the reader thread and release the device."""
        if self._on_reader_thread():
            self._reader_asks_to_end(closes_device=True)
            return
        with self._patience.ending(), self._lock:
            self._end_reader()
            self._is_awaited = False
            device, self._device = self._device, None
            if device is not None:
                give_back(device, self._context.logger)

    @property
    def is_open(self) -> bool:
        """Whether the device is open at this moment."""
        reader = self._reader
        return (reader.device if reader is not None else self._device) is not None

    @property
    def health(self) -> TransportHealth:
        """Health of the transport."""
        # A framer need not know how many bytes wait for the end of a frame.
        pending = getattr(self._framer, "pending_bytes", 0)
        return self._tally.health(self._state(), pending)

    def _state(self) -> TransportState:
        if self.is_open:
            return TransportState.CONNECTED
        reader = self._reader
        if self._is_awaited or (reader is not None and not reader.is_stopping):
            return TransportState.RECONNECTING
        return TransportState.CLOSED

    def _on_reader_thread(self) -> bool:
        readers = [self._reader, *self._left_behind]
        return any(reader is not None and reader.is_current_thread for reader in readers)

    def _reader_asks_to_end(self, *, closes_device: bool) -> None:
        reader = self._reader
        # One that was left behind has nothing to say about its successor.
        if reader is not None and reader.is_current_thread:
            reader.request_stop()
            if closes_device:
                reader.close_device_at_end()

    def _collect_stopped_reader(self) -> None:
        """Take the device back from a reader that was stopped from within `on_frame`."""
        if self._reader is not None and self._reader.is_stopping:
            self._end_reader()

    def _end_reader(self) -> None:
        reader = self._reader
        if reader is None:
            return
        reader.request_stop()
        if reader.join(STOP_TIMEOUT_S):
            self._device = reader.device
        else:
            reader.close_device_at_end()
            self._left_behind = [r for r in self._left_behind if not r.join(0.0)] + [reader]
            self._context.logger.error(
                f"on_frame has not returned for {STOP_TIMEOUT_S:g} s; its thread is left behind"
            )
        self._reader = None
