"""Topics shared with one other process of this machine: a manager's, or its child's.

Each side tells the other what it subscribes to, and sends only that. Both ends are the same.
Whether a subscription matches, and what is kept for it, is decided where the publisher is.
What arrives is unpickled, so a link is for processes that trust each other completely.
"""

import os
import pickle
import socket
import threading
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from typing import Any

from rosbase.clock import SystemClock
from rosbase.local.bus import Bus
from rosbase.local.endpoints import Channel, LocalSubscription
from rosbase.logger import RosbaseLogger
from rosbase.qos import QoSProfile
from rosbase.runtime.executor import Executor

__all__ = ["Link"]

_FOR_EVER_NS = 1 << 62
_PATIENCE_S = 0.5
_REPORT_S = 5.0
_MANY_RECORDS = 1000


class Link:
    """One end of a connection between two buses.

    Two threads serve it: one sends, so that publishing never waits for the other process, and
    one receives. While the other process is slower than the publisher, a topic keeps as many
    messages as its subscription there is deep, and the oldest go.
    """

    def __init__(
        self,
        bus: Bus,
        connection: "Connection[Any, Any]",
        name: str,
        on_record: Callable[[int, str], object] | None = None,
    ) -> None:
        """Takes this process's end of a connection; `start` makes it a link.

        Args:
            bus: The topics to share.
            connection: To the other process. The link closes it.
            name: How the log calls the other process.
            on_record: Called with level and text of what `send_record` sends there.
        """
        self._bus = bus
        self._connection = connection
        self._name = name
        self._on_record = on_record
        self._logger = RosbaseLogger("link")
        self._executor = Executor(SystemClock())
        self._ending = False
        self._record_lock = threading.Lock()
        self._records_waiting = 0
        self._records_left_out = 0
        self._wanted_there: dict[tuple[str, Channel], LocalSubscription] = {}
        self._wanted_here: dict[tuple[str, Channel], QoSProfile] = {}
        self._sender = self._thread("send", self._send_all)
        self._receiver = self._thread("receive", self._receive_all)

    def start(self, *first: Any) -> None:
        """Begins to share topics; before that, the other end gets `first`, one by one."""
        for value in first:
            self._executor.call_soon(partial(self._send_bytes, pickle.dumps(value)))
        self._sender.start()
        self._receiver.start()
        self._bus.add_link(self)

    def audience_changed(
        self, topic: str, msg_type: type, channel: Channel, profile: QoSProfile | None
    ) -> None:
        """Tells the other end what is wanted here."""
        if self._wanted_here.get((topic, channel)) == profile:
            return
        if profile is None:
            del self._wanted_here[topic, channel]
        else:
            self._wanted_here[topic, channel] = profile
        self._send_soon("want", topic, msg_type, channel, profile)

    def send_record(self, level: int, text: str) -> None:
        """Has the other end log a text, at a level of the standard library's `logging`.

        While it is slower than whoever logs, the newest records are left out, and counted.
        """
        with self._record_lock:
            if self._records_waiting >= _MANY_RECORDS:
                self._records_left_out += 1
                return
            self._records_waiting += 1
        self._executor.call_soon(partial(self._send_record, level, text))

    def close(self) -> None:
        """Ends it: what waits to be sent or received has half a second for it. Idempotent."""
        self._bus.remove_link(self)
        self._executor.call_soon(self._end)
        for thread in (self._sender, self._receiver):
            if thread.is_alive():
                thread.join(_PATIENCE_S)
        if not self._connection.closed:
            with socket.socket(fileno=os.dup(self._connection.fileno())) as end:
                _shut(end)
            for thread in (self._sender, self._receiver):
                if thread.is_alive():
                    thread.join()
            self._connection.close()
        for subscription in self._wanted_there.values():
            self._bus.remove_subscription(subscription)
        self._wanted_there.clear()

    def _thread(self, what: str, target: Callable[[], None]) -> threading.Thread:
        return threading.Thread(target=target, name=f"link-{self._name}-{what}", daemon=True)

    # On the sending thread.

    def _send_all(self) -> None:
        self._executor.spin_until(_FOR_EVER_NS, lambda: self._ending)
        with socket.socket(fileno=os.dup(self._connection.fileno())) as end:
            # The other end has everything, and will see that no more comes.
            _shut(end, socket.SHUT_WR)

    def _end(self) -> None:
        self._ending = True

    def _send_soon(self, *values: Any) -> None:
        self._executor.call_soon(partial(self._send, *values))

    def _send(self, *values: Any) -> None:
        try:
            data = pickle.dumps(values, pickle.HIGHEST_PROTOCOL)
        except Exception as error:
            self._report(f"cannot send {values[0]} {values[1]}", error)
            return
        self._send_bytes(data)

    def _send_bytes(self, data: bytes) -> None:
        try:
            self._connection.send_bytes(data)
        except OSError:
            # The other end is gone; whoever started it says so.
            self._ending = True

    def _send_record(self, level: int, text: str) -> None:
        with self._record_lock:
            self._records_waiting -= 1
            left_out, self._records_left_out = self._records_left_out, 0
        self._send("record", level, f"{text} ... {left_out} more records" if left_out else text)

    # On the receiving thread.

    def _receive_all(self) -> None:
        while True:
            try:
                data = self._connection.recv_bytes()
            except (EOFError, OSError):
                return
            try:
                what, *values = pickle.loads(data)
                getattr(self, f"_take_{what}")(*values)
            except Exception as error:
                self._report("cannot take what it sends", error)

    def _take_message(self, topic: str, channel: Channel, message: Any) -> None:
        self._bus.deliver_from(self, topic, channel, message)

    def _take_record(self, level: int, text: str) -> None:
        if self._on_record is not None:
            self._on_record(level, text)

    def _take_want(
        self, topic: str, msg_type: type, channel: Channel, profile: QoSProfile | None
    ) -> None:
        known = self._wanted_there.get((topic, channel))
        if known is not None and profile:
            self._bus.resize_subscription(known, profile)
        elif known is not None:
            self._bus.remove_subscription(self._wanted_there.pop((topic, channel)))
        elif profile:
            send = partial(self._send, "message", topic, channel)
            wanted = LocalSubscription(topic, send, profile, self._executor.call_soon, self)
            self._bus.add_subscription(wanted, msg_type)
            self._wanted_there[topic, channel] = wanted

    def _report(self, what: str, error: Exception) -> None:
        message = f"{self._name}: {what}: {type(error).__name__}: {error}"
        self._logger.log_throttle(message, _REPORT_S, "ERROR")


def _shut(end: socket.socket, how: int = socket.SHUT_RDWR) -> None:
    try:
        end.shutdown(how)
    except OSError:
        # The other end has gone first.
        pass
