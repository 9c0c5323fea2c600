"""Devices that send to a broker, for the contract: the broker is one with its device."""

import itertools
import threading
from collections.abc import Mapping
from pathlib import Path

from rosbase.errors import TransportError
from rosbase.parameters import ParameterValue
from support.mosquitto import Mosquitto
from support.mqtt import Publisher, ScriptedBroker, publish_packet

__all__ = ["MosquittoPeer", "ScriptedPeer"]


class ScriptedPeer:
    """The broker is scripted: what it sends, it sends at once, to whoever is connected."""

    def __init__(self) -> None:
        self._broker = ScriptedBroker()
        self._is_plugged = True

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        return {"server_address": self._broker.address}

    def send(self, payload: bytes) -> None:
        if not self._is_plugged:
            raise TransportError("the broker has ended")
        self._broker.send(publish_packet(b"esp32/imu", payload))

    send_raw = send

    def unplug(self) -> None:
        self._is_plugged = False
        self._broker.close()

    def replug(self) -> None:
        self._broker = ScriptedBroker(port=self._broker.port)
        self._is_plugged = True

    close = unplug


class MosquittoPeer:
    """The broker is mosquitto, and can be killed."""

    _numbers = itertools.count()

    def __init__(self, folder: Path) -> None:
        own = folder / str(next(self._numbers))
        own.mkdir()
        self._broker = Mosquitto(own)
        self._publisher: Publisher | None = Publisher(self._broker.port)
        # Paho waits long for an answer to what was published when it was closed.
        self._lock = threading.Lock()

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        return {"server_address": self._broker.address, "qos": 1}

    def send(self, payload: bytes) -> None:
        with self._lock:
            if self._publisher is None:
                raise TransportError("the broker has ended")
            self._publisher.publish(payload)

    send_raw = send

    def unplug(self) -> None:
        with self._lock:
            if self._publisher is not None:
                self._publisher.close()
                self._publisher = None
        self._broker.stop()

    def replug(self) -> None:
        self._broker.start()
        self._publisher = Publisher(self._broker.port)

    close = unplug
