"""Channels and the clients that listen to them, on a real server."""

import os
import threading
from collections.abc import Callable
from contextlib import ExitStack

import pytest
from foxglove import Channel
from foxglove.websocket import ChannelView, Client, ServerListener

from rosbase.messages import String
from rosbase.wire import schema
from rosbase_view.foxglove.channels import Channels
from rosbase_view.foxglove.notices import Notices
from rosbase_view.foxglove.server import Server
from rosbase_view.reports import Survey
from support.foxglove_client import FoxgloveClient
from support.waiting import wait_until

KEY = ("/name", 1)
FOUND = Survey(
    (), {KEY: {"name": "/name", "types": [], "publishers": [], "subscriptions": []}}, (), ()
)


class Listener(ServerListener):
    """Tells which channel a client has begun to listen to."""

    def __init__(self, tell: Callable[[str], object]) -> None:
        self._tell = tell

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        self._tell(channel.topic)


def descriptors() -> int:
    return len(os.listdir("/proc/self/fd"))


@pytest.fixture(scope="module", autouse=True)
def warm_sdk() -> None:
    """Takes what the SDK takes once for the process, so that no test seems to leak it."""
    server = Server()
    server.start("warm up", "127.0.0.1", 0, Listener(print))
    started = descriptors()
    server.stop()
    wait_until(lambda: descriptors() < started, "the end of the server")


def test_a_client_that_listens_as_soon_as_it_sees_a_channel_is_heard() -> None:
    class Quick(Server):
        """Has a client that listens before the channel is returned."""

        def open_channel(self, topic: str, type_name: str, schema: str) -> Channel:
            channel = super().open_channel(topic, type_name, schema)
            clients[0].subscribe(topic)
            assert has_listened.wait(10)
            return channel

    def tell(topic: str) -> None:
        channels.count_listener(topic)
        has_listened.set()

    before = descriptors()
    clients: list[FoxgloveClient] = []
    has_listened = threading.Event()
    server = Quick()
    channels = Channels(
        server, Notices(server), lambda key, topic: ("std_msgs/msg/String", schema(String))
    )
    with ExitStack() as stack:
        port = server.start("test", "127.0.0.1", 0, Listener(tell))
        stack.callback(server.stop)
        clients.append(stack.enter_context(FoxgloveClient(port)))
        channels.update(FOUND)
        assert channels.listened().topics == {KEY: 1}
        channels.send(KEY, 1, b"data")
        clients[0].until(lambda: clients[0].messages, "the message")
    # The SDK closes its sockets a moment later.
    wait_until(lambda: descriptors() <= before, "the end of the server")
