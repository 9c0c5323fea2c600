"""The transport `serial`: open, start, stop and close, from any thread and in any order."""

import threading

from imu_serial.config import SerialConfig
from imu_serial.port import Port
from imu_serial.reader_thread import ReaderThread
from rosbase.errors import TransportError
from rosbase.transport import (
    OnFrame,
    Tally,
    Transport,
    TransportContext,
    TransportHealth,
    TransportState,
)

__all__ = ["STOP_TIMEOUT_S", "SerialTransport"]

STOP_TIMEOUT_S = 2.0
"""How long `stop` waits for an `on_frame` that does not return."""


class SerialTransport(Transport):
    """Lines from a serial port."""

    def __init__(self, config: SerialConfig, context: TransportContext) -> None:
        """Touches nothing yet."""
        self._config = config
        self._context = context
        self._tally = Tally()
        self._port: Port | None = None
        self._reader: ReaderThread | None = None
        self._left_behind: list[ReaderThread] = []
        self._is_awaited = False
        # Serialises the four calls. The reader thread never takes it: it may be joined under it.
        self._lock = threading.RLock()

    def open(self) -> None:
        """Takes the port; with `wait_for_device` an absent one is left to the reader thread."""
        if self._on_reader_thread():
            return
        with self._lock:
            self._collect_stopped_reader()
            if self._reader is not None or self._port is not None:
                return
            try:
                self._port = Port(self._config)
            except TransportError as error:
                self._tally.last_error = str(error)
                if not (self._config.wait_for_device and error.retryable):
                    raise
                if not self._is_awaited:
                    self._context.logger.warning(f"{error}; waiting for it")
                self._is_awaited = True
            else:
                self._tally.last_error = ""
                self._context.logger.info(
                    f"opened {self._port.name} at {self._config.baudrate} baud"
                )

    def start(self, on_frame: OnFrame) -> None:
        """Starts the reader thread, on the open port, or waiting for one."""
        if self._on_reader_thread():
            return
        with self._lock:
            self._collect_stopped_reader()
            if self._reader is not None:
                return
            self.open()
            port = self._port
            try:
                reader = ReaderThread(self._config, self._context, port, on_frame, self._tally)
                # Known before it runs: the first frame may make `on_frame` call us.
                self._reader, self._port = reader, None
                reader.start()
            except (OSError, RuntimeError) as error:
                self._reader, self._port = None, port
                raise TransportError(f"no reader can be started: {error}") from error
            self._is_awaited = False

    def stop(self) -> None:
        """Ends the reader thread; waits for it, except on that thread itself."""
        if self._on_reader_thread():
            self._reader_asks_to_end(closes_port=False)
            return
        with self._lock:
            self._end_reader()

    def close(self) -> None:
        """Ends the reader thread and gives the port back."""
        if self._on_reader_thread():
            self._reader_asks_to_end(closes_port=True)
            return
        with self._lock:
            self._end_reader()
            self._is_awaited = False
            if self._port is not None:
                self._port.close()
                self._port = None

    @property
    def is_open(self) -> bool:
        """Whether the port is held at this moment."""
        reader = self._reader
        return (reader.port if reader is not None else self._port) is not None

    @property
    def health(self) -> TransportHealth:
        """How it is doing."""
        return self._tally.health(self._state())

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

    def _reader_asks_to_end(self, *, closes_port: bool) -> None:
        reader = self._reader
        # One that was left behind has nothing to say about its successor.
        if reader is not None and reader.is_current_thread:
            reader.request_stop()
            if closes_port:
                reader.close_port_at_end()

    def _collect_stopped_reader(self) -> None:
        """Takes the port back from a reader that was stopped from within `on_frame`."""
        if self._reader is not None and self._reader.is_stopping:
            self._end_reader()

    def _end_reader(self) -> None:
        reader = self._reader
        if reader is None:
            return
        reader.request_stop()
        if reader.join(STOP_TIMEOUT_S):
            self._port = reader.port
        else:
            reader.close_port_at_end()
            self._left_behind = [r for r in self._left_behind if not r.join(0.0)] + [reader]
            self._context.logger.error(
                f"on_frame has not returned for {STOP_TIMEOUT_S:g} s; its thread is left behind"
            )
        self._reader = None
