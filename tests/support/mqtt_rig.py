"""Transports on brokers, and the frames that came through."""

import queue
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from imu_mqtt.config import PARAMETERS, MqttConfig
from imu_mqtt.transport import MqttTransport
from rosbase.clock import SystemClock
from rosbase.contracts.transport import TransportContext, TransportState
from rosbase.logger import RosbaseLogger
from support.waiting import wait_until

__all__ = ["MqttRig", "config", "context", "elapsed", "wait_for_state", "warnings"]


def config(address: str = "tcp://127.0.0.1:1", **changes: Any) -> MqttConfig:
    """The settings with some parameters changed."""
    defaults = {spec.name: spec.default for spec in PARAMETERS}
    return MqttConfig.from_values({**defaults, "server_address": address, **changes})


def context() -> TransportContext:
    """A real clock, and a logger that `caplog` hears."""
    return TransportContext(SystemClock(), RosbaseLogger("mqtt_test"))


class MqttRig:
    """Makes transports and keeps the frames that come through them."""

    def __init__(self) -> None:
        self.frames: queue.Queue[tuple[bytes, int]] = queue.Queue()
        self.made: list[MqttTransport] = []

    def transport(self, address: str, **changes: Any) -> MqttTransport:
        self.made.append(MqttTransport(config(address, **changes), context()))
        return self.made[-1]

    def started(self, address: str, **changes: Any) -> MqttTransport:
        transport = self.transport(address, **changes)
        transport.start(self.keep)
        return transport

    def keep(self, frame: bytes, stamp_ns: int) -> None:
        self.frames.put((frame, stamp_ns))

    def next(self) -> bytes:
        return self.frames.get(timeout=20)[0]

    def prove(self, publish: Callable[[bytes], None]) -> None:
        """Publishes until something comes through, and then once more."""

        def arrived() -> bool:
            publish(b"proof")
            try:
                return self.frames.get(timeout=0.05)[0] == b"proof"
            except queue.Empty:
                return False

        wait_until(arrived, "a message to come through")
        publish(b"last")
        wait_until(lambda: self.next() == b"last", "the last proof")


def wait_for_state(transport: MqttTransport, wanted: TransportState) -> None:
    wait_until(lambda: transport.health.state is wanted, f"state {wanted}")


def warnings(caplog: pytest.LogCaptureFixture) -> list[str]:
    """What the log warns of."""
    return [r.message for r in caplog.records if r.levelname == "WARNING"]


def elapsed(call: Callable[[], object]) -> float:
    start = time.monotonic()
    call()
    return time.monotonic() - start


def network_threads() -> list[threading.Thread]:
    """Those of all transports that run."""
    return [thread for thread in threading.enumerate() if thread.name == "imu-mqtt"]
