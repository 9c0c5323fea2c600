"""A port that comes and goes, a transport on it, and the frames that came through."""

import queue
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from imu_serial.plugin import rosbase_transports
from rosbase.clock import Clock, SystemClock
from rosbase.contracts.transport import Transport, TransportContext, TransportState
from rosbase.logger import RosbaseLogger
from rosbase.parameters import ParameterValue
from support.serial_port import PluggablePort
from support.waiting import wait_until


class SerialRig:
    """A port, a transport on it, and the frames that came through."""

    def __init__(self, folder: Path) -> None:
        self.port = PluggablePort(folder)
        self.frames: queue.Queue[tuple[bytes, int]] = queue.Queue()
        self.made: list[Transport] = []

    def transport(
        self,
        *,
        wait: bool = False,
        path: Path | str | None = None,
        clock: Clock | None = None,
        **more: ParameterValue,
    ) -> Transport:
        """A transport for the port or another, with further parameters."""
        (plugin,) = rosbase_transports()
        device_path = str(path or self.port.path)
        values: dict[str, ParameterValue] = {spec.name: spec.default for spec in plugin.parameters}
        values |= {"device_path": device_path, "wait_for_device": wait, **more}
        context = TransportContext(clock or SystemClock(), RosbaseLogger("serial_test"))
        self.made.append(plugin.create(values, context))
        return self.made[-1]

    def said(self, messages: Sequence[str]) -> list[str]:
        """Which of the messages are about the port, and not only that it was opened."""
        path = str(self.port.path)
        return [text for text in messages if path in text and not text.startswith("opened")]

    def keep(self, frame: bytes, stamp_ns: int) -> None:
        self.frames.put((frame, stamp_ns))

    def writes(self, data: bytes) -> bool:
        self.port.write(data)
        return True

    def next(self) -> bytes:
        return self.frames.get(timeout=20)[0]

    def started(self, **more: Any) -> Transport:
        """A transport that has proved to read."""
        self.port.plug()
        transport = self.transport(**more)
        transport.open()
        transport.start(self.keep)
        self.prove()
        return transport

    def prove(self) -> None:
        """Writes until the reader, which first discards what is old, hands something over."""

        def arrived() -> bool:
            self.port.write(b"proof\n")
            try:
                return self.frames.get(timeout=0.05)[0] == b"proof"
            except queue.Empty:
                return False

        wait_until(arrived, "a line to come through")
        self.port.write(b"last\n")
        wait_until(lambda: self.next() == b"last", "the last proof")


def wait_for_state(transport: Transport, wanted: TransportState) -> None:
    wait_until(lambda: transport.health.state is wanted, f"state {wanted}")


def elapsed(call: Callable[[], object]) -> float:
    start = time.monotonic()
    call()
    return time.monotonic() - start
