"""A client of Foxglove's WebSocket protocol, on the library `websockets`, without the SDK."""

import json
import socket
import struct
import threading
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, NamedTuple

from websockets.exceptions import ConnectionClosedError
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from support.waiting import wait_until

__all__ = ["FoxgloveClient", "Received"]

SUBPROTOCOL = Subprotocol("foxglove.sdk.v1")
_MESSAGE, _TIME, _SERVICE, _PLAYBACK = 1, 2, 3, 5
_PUBLISH, _CALL, _CONTROL = 1, 2, 3


class Received(NamedTuple):
    """A message of a channel."""

    topic: str
    stamp_ns: int
    data: bytes


class FoxgloveClient:
    """Connects, and keeps what the server sends. A thread of its own reads."""

    def __init__(self, port: int, *, reads: bool = True) -> None:
        """Connects.

        Args:
            port: Where the server listens.
            reads: Whether it reads what comes after the first line.
        """
        self.port = port
        # Small buffers are soon full.
        buffers = None if reads else 4096
        connection = socket.socket()
        if buffers is not None:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffers)
        connection.connect(("127.0.0.1", port))
        self._stack = ExitStack()
        self._socket = self._stack.enter_context(
            connect(
                f"ws://127.0.0.1:{port}",
                sock=connection,
                subprotocols=[SUBPROTOCOL],
                compression=None,
                max_size=None,
                max_queue=None if reads else 1,
            )
        )
        assert self._socket.subprotocol == SUBPROTOCOL
        self.info: dict[str, Any] = json.loads(self._socket.recv())
        assert self.info["op"] == "serverInfo"
        self.channels: dict[int, dict[str, Any]] = {}
        self.services: dict[int, dict[str, Any]] = {}
        self.messages: list[Received] = []
        self.parameters: dict[str, dict[str, Any]] = {}
        self.answered: dict[str, list[dict[str, Any]]] = {}
        """Parameters by the id of the request."""
        self.statuses: dict[str, str] = {}
        self.times: list[int] = []
        self.published: dict[str, list[str]] = {}
        self.subscribed: dict[str, list[str]] = {}
        self.offered: dict[str, list[str]] = {}
        self.responses: dict[int, bytes | str] = {}
        """Response of each call, or the text of its failure."""
        self.playback: list[dict[str, Any]] = []
        self.is_closed = False
        self._subscriptions: dict[int, str] = {}
        self._last = 0
        self._thread = threading.Thread(target=self._read)
        if reads:
            self.read()

    def __enter__(self) -> "FoxgloveClient":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def read(self) -> None:
        """Begins to read."""
        self._thread.start()

    def close(self) -> None:
        """Ends the connection."""
        if self._thread.ident is None:
            # It would wait for what it does not read.
            self._socket.socket.close()
        self._stack.close()
        if self._thread.ident is not None:
            self._thread.join()

    def until(self, condition: Callable[[], object], what: str) -> None:
        """Waits for what the server sends."""
        wait_until(condition, f"{what}; {self.statuses}")

    def channel(self, topic: str) -> dict[str, Any]:
        """Waits for a channel."""
        self.until(lambda: topic in self.topics, f"channel {topic}, not {self.topics}")
        return next(one for one in self.channels.values() if one["topic"] == topic)

    @property
    def topics(self) -> list[str]:
        """Topics of all channels."""
        return [one["topic"] for one in list(self.channels.values())]

    def subscribe(self, topic: str, channel_id: int | None = None) -> int:
        """Begins to listen; gives the number of the subscription."""
        found = self.channel(topic)["id"] if channel_id is None else channel_id
        self._last += 1
        self._subscriptions[self._last] = topic
        self.send("subscribe", subscriptions=[{"id": self._last, "channelId": found}])
        return self._last

    def unsubscribe(self, number: int) -> None:
        """Ends listening."""
        self.send("unsubscribe", subscriptionIds=[number])

    def of(self, topic: str) -> list[Received]:
        """Messages of a topic so far."""
        return [one for one in list(self.messages) if one.topic == topic]

    def get_parameters(self, *names: str) -> dict[str, Any]:
        """Asks for parameters; gives their values by name."""
        self._last += 1
        request = f"get-{self._last}"
        self.send("getParameters", parameterNames=list(names), id=request)
        self.until(lambda: request in self.answered, "the parameters")
        return {one["name"]: one["value"] for one in self.answered[request]}

    def set_parameters(self, *parameters: dict[str, Any]) -> dict[str, Any]:
        """Sets parameters; gives the values that the server answers."""
        self._last += 1
        request = f"set-{self._last}"
        self.send("setParameters", parameters=list(parameters), id=request)
        self.until(lambda: request in self.answered, "the answer")
        return {one["name"]: one["value"] for one in self.answered[request]}

    def call(self, service: str, data: bytes) -> bytes | str:
        """Calls a service; gives the response, or the text of the failure."""

        def found() -> list[int]:
            return [n for n, one in list(self.services.items()) if one["name"] == service]

        self.until(found, f"service {service}")
        self._last += 1
        number = self._last
        self._socket.send(struct.pack("<BIII", _CALL, found()[0], number, 3) + b"cdr" + data)
        self.until(lambda: number in self.responses, "the response")
        return self.responses[number]

    def advertise(self, topic: str, type_name: str, number: int = 1) -> None:
        """Says that it will publish."""
        channel = {"id": number, "topic": topic, "encoding": "cdr", "schemaName": type_name}
        self.send("advertise", channels=[channel])

    def publish(self, data: bytes, number: int = 1) -> None:
        """Publishes a message."""
        self._socket.send(struct.pack("<BI", _PUBLISH, number) + data)

    def control(self, *, plays: bool, speed: float = 1.0, seek_ns: int | None = None) -> str:
        """Asks for a state of the playback; gives the id of the request."""
        self._last += 1
        request = f"control-{self._last}".encode()
        has_seek, seek_ns = seek_ns is not None, seek_ns or 0
        head = struct.pack("<BBfBQI", _CONTROL, not plays, speed, has_seek, seek_ns, len(request))
        self._socket.send(head + request)
        return request.decode()

    def send(self, op: str, **arguments: Any) -> None:
        """Sends a request."""
        self._socket.send(json.dumps({"op": op, **arguments}))

    # On the thread that reads.

    def _read(self) -> None:
        try:
            for frame in self._socket:
                if isinstance(frame, bytes):
                    self._take_bytes(frame)
                else:
                    self._take(json.loads(frame))
        except ConnectionClosedError:
            # The SDK answers no end of a connection.
            pass
        self.is_closed = True

    def _take(self, frame: dict[str, Any]) -> None:
        take = getattr(self, f"_take_{frame['op']}", None)
        assert take is not None, frame
        take(frame)

    def _take_serverInfo(self, frame: dict[str, Any]) -> None:  # noqa: N802 - the server's name
        self.info = frame

    def _take_advertise(self, frame: dict[str, Any]) -> None:
        self.channels |= {one["id"]: one for one in frame["channels"]}

    def _take_unadvertise(self, frame: dict[str, Any]) -> None:
        for number in frame["channelIds"]:
            del self.channels[number]

    def _take_advertiseServices(self, frame: dict[str, Any]) -> None:  # noqa: N802 - as above
        self.services |= {one["id"]: one for one in frame["services"]}

    def _take_unadvertiseServices(self, frame: dict[str, Any]) -> None:  # noqa: N802 - as above
        for number in frame["serviceIds"]:
            del self.services[number]

    def _take_parameterValues(self, frame: dict[str, Any]) -> None:  # noqa: N802 - as above
        self.parameters |= {one["name"]: one for one in frame["parameters"]}
        if "id" in frame:
            self.answered[frame["id"]] = frame["parameters"]

    def _take_status(self, frame: dict[str, Any]) -> None:
        self.statuses[frame.get("id", "")] = frame["message"]

    def _take_removeStatus(self, frame: dict[str, Any]) -> None:  # noqa: N802 - as above
        for one in frame["statusIds"]:
            self.statuses.pop(one, None)

    def _take_connectionGraphUpdate(self, frame: dict[str, Any]) -> None:  # noqa: N802 - as above
        for one in frame["publishedTopics"]:
            self.published[one["name"]] = one["publisherIds"]
        for one in frame["subscribedTopics"]:
            self.subscribed[one["name"]] = one["subscriberIds"]
        for one in frame["advertisedServices"]:
            self.offered[one["name"]] = one["providerIds"]
        for name in frame["removedTopics"]:
            self.published.pop(name, None)
            self.subscribed.pop(name, None)
        for name in frame["removedServices"]:
            self.offered.pop(name, None)

    def _take_serviceCallFailure(self, frame: dict[str, Any]) -> None:  # noqa: N802 - as above
        self.responses[frame["callId"]] = frame["message"]

    def _take_bytes(self, data: bytes) -> None:
        kind = data[0]
        if kind == _MESSAGE:
            number, stamp_ns = struct.unpack_from("<IQ", data, 1)
            self.messages.append(Received(self._subscriptions[number], stamp_ns, data[13:]))
        elif kind == _TIME:
            self.times.append(struct.unpack_from("<Q", data, 1)[0])
        elif kind == _SERVICE:
            _, call, size = struct.unpack_from("<III", data, 1)
            self.responses[call] = data[13 + size :]
        elif kind == _PLAYBACK:
            state, now_ns, speed, did_seek, size = struct.unpack_from("<BQfBI", data, 1)
            request = data[19 : 19 + size].decode()
            self.playback.append(
                {"state": state, "now_ns": now_ns, "speed": speed, "did_seek": bool(did_seek),
                 "request": request}
            )  # fmt: skip
        else:
            raise AssertionError(f"unknown kind of message {kind}")
