"""A simulated device that sends to an embedded broker: both in this process."""

import asyncio
import socket
from collections import deque
from collections.abc import Mapping
from typing import Any

import paho.mqtt.client as mqtt
from paho.mqtt.enums import CallbackAPIVersion

from rosbase import NotInstalledError, ParameterValue, TransportError, background_thread

try:
    from amqtt.broker import Broker
    from amqtt.errors import ProtocolHandlerError
except ImportError as error:
    raise NotInstalledError(
        "a simulated device over MQTT needs the broker amqtt: pip install 'amqtt>=0.11'"
    ) from error

__all__ = ["BrokeredDevice", "EmbeddedBroker"]

_TOPIC = "esp32/imu"
_PATIENCE_S = 5.0
_LOOKS = 50
_GOODBYE_S = 1.0
_MOST_UNDER_WAY = 20


class _CleanBroker(Broker):  # type: ignore[misc]  # amqtt is an extra, and not checked
    """A broker that ends its clients before itself: amqtt does both at once, and at times hangs."""

    def __init__(self, config: dict[str, Any]) -> None:
        super().__init__(config)
        self._clients: dict[Any, Any] = {}
        self._is_closing = False

    async def stream_connected(self, reader: Any, writer: Any, listener_name: str) -> None:
        task = asyncio.current_task()
        self._clients[task] = writer
        try:
            if not self._is_closing:
                await super().stream_connected(reader, writer, listener_name)
        finally:
            del self._clients[task]
            writer.close()

    async def shutdown(self) -> None:
        self._is_closing = True
        for writer in self._clients.values():
            writer.close()
        if self._clients:
            await asyncio.wait(self._clients, timeout=_GOODBYE_S)
        await super().shutdown()
        # Sockets are closed in the next round of the loop.
        await asyncio.sleep(0)


def _report(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Report an error of the broker, unless a client disconnected while the broker answered it."""
    if not isinstance(context.get("exception"), (ProtocolHandlerError, ConnectionError)):
        loop.default_exception_handler(context)


class EmbeddedBroker:
    """A broker in Python, on a local port, on a thread. For demos and tests."""

    def __init__(self, port: int | None = None) -> None:
        """Start the broker.

        Raises:
            TransportError: It does not start.
        """
        self.port = port or _free_port()
        """Port where it listens."""
        self._loop = asyncio.new_event_loop()
        self._loop.set_exception_handler(_report)
        self._thread = background_thread(self._loop.run_forever, "broker")
        self._thread.start()
        try:
            self._broker = self._run(self._start())
        except Exception as error:
            self._end()
            raise TransportError(f"the broker does not start: {error!r}") from error

    @property
    def address(self) -> str:
        """Address for clients."""
        return f"tcp://127.0.0.1:{self.port}"

    def close(self) -> None:
        """Close it, and every connection to it. Idempotent."""
        if self._thread.is_alive():
            self._run(self._broker.shutdown())
            self._end()

    async def _start(self) -> Any:
        broker = _CleanBroker(
            {
                "listeners": {"default": {"type": "tcp", "bind": f"127.0.0.1:{self.port}"}},
                "plugins": {"amqtt.plugins.authentication.AnonymousAuthPlugin": {}},
            }
        )
        await broker.start()
        return broker

    def _run(self, what: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(what, self._loop).result(_PATIENCE_S)

    def _end(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(_PATIENCE_S)
        self._loop.close()


class BrokeredDevice:
    """A device that sends to an embedded broker: a `rosbase.PluggableDevice`.

    Its plug is the broker's: if you pull it, both the reader and the device lose the broker.
    """

    def __init__(self) -> None:
        """Start the broker, and connect to it.

        Raises:
            TransportError: One of the two does not work.
        """
        self._port: int | None = None
        self._is_closed = True
        self._under_way: deque[mqtt.MQTTMessageInfo] = deque()
        self.replug()

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        """Parameters with which the transport `mqtt` reaches this device."""
        return {"server_address": self._broker.address, "mqtt_topic": _TOPIC, "qos": 1}

    @property
    def has_room(self) -> bool:
        """Whether the broker has taken most of the sent payloads."""
        while self._under_way and self._under_way[0].is_published():
            self._under_way.popleft()
        return not self._is_closed and len(self._under_way) < _MOST_UNDER_WAY

    def replug(self) -> None:
        """Start the broker, at its port, and connect to it. Idempotent.

        Raises:
            TransportError: One of the two does not work.
        """
        if not self._is_closed:
            return
        self._broker = EmbeddedBroker(self._port)
        self._port = self._broker.port
        self._under_way.clear()
        self._client = mqtt.Client(CallbackAPIVersion.VERSION2)
        try:
            self._client.connect("127.0.0.1", self._port)
        except OSError as error:
            self._broker.close()
            raise TransportError(f"the broker cannot be reached: {error}") from error
        self._client.loop_start()
        self._is_closed = False

    def unplug(self) -> None:
        """Disconnect, and close the broker. Idempotent."""
        if not self._is_closed:
            self._is_closed = True
            self._client.disconnect()
            self._client.loop_stop()
            self._broker.close()

    def send(self, payload: bytes) -> None:
        """Send one payload. Wait while too many are on their way.

        Raises:
            TransportError: The link has been closed, or the broker does not take it.
        """
        if self._is_closed:
            raise TransportError("the simulated device has been closed")
        self._under_way.append(self._client.publish(_TOPIC, payload, qos=1))
        while len(self._under_way) > _MOST_UNDER_WAY:
            self._await(self._under_way.popleft())

    def close(self) -> None:
        """Pull the plug for good. Idempotent."""
        self.unplug()

    def _await(self, message: mqtt.MQTTMessageInfo) -> None:
        for _ in range(_LOOKS):
            try:
                message.wait_for_publish(_PATIENCE_S / _LOOKS)
                if message.is_published():
                    return
            except (RuntimeError, ValueError) as error:
                raise TransportError(f"the broker does not take it: {error}") from error
            if self._is_closed:
                break
        raise TransportError("the simulated device has been closed, or its broker has ended")


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
        return port
