"""Transports on a real broker, and the frames that came through."""

import itertools
import queue
import time
from pathlib import Path

from imu_mqtt.config import PARAMETERS, MqttConfig
from imu_mqtt.transport import MqttTransport
from rosbase.clock import SystemClock
from rosbase.contracts.transport import TransportContext
from rosbase.logger import RosbaseLogger
from rosbase.parameters import ParameterValue
from support.mosquitto import TOPIC, Mosquitto
from support.waiting import wait_until

__all__ = ["MosquittoRig"]


class MosquittoRig:
    """A broker, transports on it, and the frames that came through."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.frames: queue.Queue[tuple[bytes, int]] = queue.Queue()
        self.made: list[MqttTransport] = []
        self._brokers: list[Mosquitto] = []
        self._numbers = itertools.count()

    def broker(self, *settings: str, **more: str) -> Mosquitto:
        self._brokers.append(Mosquitto(self.folder, *settings, **more))
        return self._brokers[-1]

    def transport(self, address: str, **changes: ParameterValue) -> MqttTransport:
        values = {spec.name: spec.default for spec in PARAMETERS}
        config = MqttConfig.from_values(values | {"server_address": address} | changes)
        context = TransportContext(SystemClock(), RosbaseLogger("mqtt_test"))
        self.made.append(MqttTransport(config, context))
        return self.made[-1]

    def started(self, address: str, **changes: ParameterValue) -> MqttTransport:
        transport = self.transport(address, **changes)
        transport.open()
        transport.start(lambda frame, stamp_ns: self.frames.put((frame, stamp_ns)))
        return transport

    def next(self) -> bytes:
        return self.frames.get(timeout=20)[0]

    def prove(self, broker: Mosquitto, *options: str, topic: str = TOPIC) -> float:
        """Sends until what is sent comes through; gives how many seconds that took."""
        begun_s = time.monotonic()
        sent: set[bytes] = set()

        def arrived() -> bool:
            payload = b"proof %d" % next(self._numbers)
            sent.add(payload)
            broker.publish(payload, *options, topic=topic)
            try:
                return self.frames.get(timeout=0.05)[0] in sent
            except queue.Empty:
                return False

        wait_until(arrived, "a message to come through")
        took_s = time.monotonic() - begun_s
        # Those that were late must not be taken for what comes next.
        broker.publish(b"last", *options, topic=topic)
        wait_until(lambda: self.next() == b"last", "the last proof")
        return took_s

    def close(self) -> None:
        for transport in self.made:
            transport.close()
        for broker in self._brokers:
            broker.stop()
