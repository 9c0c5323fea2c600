"""A device that is a named pipe: as small as one that comes and goes can be."""

import itertools
import os
import select
import threading
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from rosbase.contracts.transport import SimulatedDevice, Transport, TransportContext
from rosbase.device import DeviceTransport
from rosbase.errors import DeviceNotFoundError, TransportError
from rosbase.framing import Framer, LineFramer
from rosbase.parameters import ParameterSpec, ParameterValue
from rosbase.plugins import TransportPlugin
from rosbase.testing import TransportCapabilities, TransportContract

__all__ = ["FifoContract", "FifoDevice", "FifoPeer", "make_transport"]

PARAMETERS = (
    ParameterSpec("fifo_path", "/run/imu", "the named pipe"),
    ParameterSpec("silence", 0.0, "after how long without data it is opened anew"),
    ParameterSpec("wait", default=False, description="whether an absent one is waited for"),
)
_CHUNK_BYTES = 4_096
_POLL_MS = 20


class FifoDevice:
    """The reader's end: a `rosbase.device.Device`."""

    def __init__(self, path: str) -> None:
        self.name = path
        try:
            self._fd = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as error:
            raise DeviceNotFoundError(f"{path} is not there") from error

    def fileno(self) -> int:
        return self._fd

    def read(self) -> bytes:
        try:
            data = os.read(self._fd, _CHUNK_BYTES)
        except BlockingIOError:
            return b""
        if not data:
            raise TransportError(f"{self.name} was lost")
        return data

    def discard_input(self) -> None:
        while self.read():
            pass

    def close(self) -> None:
        os.close(self._fd)


class FifoPeer:
    """The device's end: plays the device for the contract."""

    _numbers = itertools.count()

    def __init__(self, folder: Path) -> None:
        self.path = folder / f"imu{next(self._numbers)}"
        self._fd = -1
        self._lock = threading.Lock()
        self.replug()

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        return {"fifo_path": str(self.path)}

    def send(self, payload: bytes) -> None:
        self.send_raw(self.encode(payload))

    def encode(self, payload: bytes) -> bytes:
        return payload + b"\n"

    def send_raw(self, data: bytes) -> None:
        while data:
            data = data[self._write_some(data) :]

    def replug(self) -> None:
        os.mkfifo(self.path)
        # For both ends, so that it has a writer while it is plugged in, and needs no reader.
        self._fd = os.open(self.path, os.O_RDWR | os.O_NONBLOCK)

    def unplug(self) -> None:
        with self._lock:
            if self._fd >= 0:
                self.path.unlink()
                os.close(self._fd)
                self._fd = -1

    close = unplug

    def _write_some(self, data: bytes) -> int:
        with self._lock:
            if self._fd < 0:
                raise TransportError(f"{self.path} has been closed")
            try:
                return os.write(self._fd, data)
            except BlockingIOError:
                fd = self._fd
        ready = select.poll()
        ready.register(fd, select.POLLOUT)
        ready.poll(_POLL_MS)
        return 0


def make_transport(
    values: Mapping[str, ParameterValue],
    context: TransportContext,
    framer: Framer | None = None,
    device: type[FifoDevice] = FifoDevice,
) -> Transport:
    """A good transport; or one with another framer or device."""
    return DeviceTransport(
        lambda: device(str(values["fifo_path"])),
        context,
        framer=framer or LineFramer(),
        waits_for_device=bool(values["wait"]),
        reopen_after_s=float(str(values.get("silence", 0.0))),
    )


class FifoContract(TransportContract):
    """The contract of a transport for named pipes."""

    transport = "fifo"
    capabilities = TransportCapabilities(
        is_stream=True,
        can_unplug=True,
        can_be_absent=True,
        waits_with={"wait": True},
        reopens_with={"silence": 0.05},
        bad_frames=(b"x" * 70_000 + b"\n",),
    )

    def setup_method(self) -> None:
        self._folder = TemporaryDirectory()

    def teardown_method(self) -> None:
        self._folder.cleanup()

    def make_peer(self) -> SimulatedDevice:
        return FifoPeer(Path(self._folder.name))

    def plugin(self) -> TransportPlugin:
        return TransportPlugin("fifo", "lines from a named pipe", make_transport, PARAMETERS)
