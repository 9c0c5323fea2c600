"""Topics and services shared with one other process of this machine: a manager's, or its child's.

Each side tells the other its subscriptions, and sends only messages for those; `service_link` has
the part about services. Both ends are the same. The publisher's side decides whether a subscription
matches, and which messages are kept for it. Arriving data is unpickled, and unpickling may run any
code. So a link is only for processes that trust each other completely: a program and its own
children. Unreadable data ends the link. That protects against a mistake, such as a write to the
wrong descriptor, and not against an attack.
"""

import logging
import os
import pickle
import socket
import threading
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from types import NoneType
from typing import Any

from rosbase.clock import SystemClock
from rosbase.local.bus import Bus
from rosbase.local.endpoints import Channel, LocalSubscription
from rosbase.local.service_link import Kinds, ServiceLink
from rosbase.logger import RosbaseLogger
from rosbase.qos import QoSProfile
from rosbase.runtime.executor import Executor
from rosbase.runtime.signal_masks import background_thread

__all__ = ["Link"]

_FOR_EVER_NS = 1 << 62
_PATIENCE_S = 0.5
_REPORT_S = 5.0
_MANY_RECORDS = 1000
_MOST_BYTES = 1 << 28
"""Maximum size of a message on a link: 256 MiB."""


class Link:
    """One end of a connection between two buses.

    Two threads serve it: one sends, so that publishing never waits for the other process, and
    one receives. While the other process is slower than the publisher, a topic keeps as many
    messages as the depth of its subscription there. The oldest are dropped.
    """

    def __init__(
        self,
        bus: Bus,
        connection: "Connection[Any, Any]",
        name: str,
        on_record: Callable[[int, str, bool], object] | None = None,
        on_fault: Callable[[str], object] | None = None,
    ) -> None:
        """Take this process's end of a connection; `start` makes it a link.

        Args:
            bus: The topics to share.
            connection: The connection to the other process. The link closes it.
            name: Name of the other process in the log.
            on_record: Called with the arguments of the other end's `send_record`, for each
                record.
            on_fault: Called with the reason when unreadable data comes. The link receives nothing
                any more then. If not given, the reason is logged, and the link goes on receiving.
        """
        self._bus = bus
        self._connection = connection
        self._name = name
        self._on_record = on_record
        self._on_fault = on_fault
        self._logger = RosbaseLogger("link")
        self._executor = Executor(SystemClock())
        self._ending = False
        self._record_lock = threading.Lock()
        self._records_waiting = 0
        self._records_left_out = 0
        self._wanted_there: dict[tuple[str, Channel], LocalSubscription] = {}
        self._wanted_here: dict[tuple[str, Channel], QoSProfile] = {}
        self._services = ServiceLink(bus.services, self._try_send, self._executor.call_soon)
        # What the other end may say.
        self._kinds: Kinds = {
            "message": (self._take_message, (str, (str, int), object)),
            "record": (self._take_record, (int, str, bool)),
            "want": (self._take_want, (str, type, (str, int), (QoSProfile, NoneType))),
            **self._services.kinds,
        }
        self._sender = self._thread("send", self._send_all)
        self._receiver = self._thread("receive", self._receive_all)

    def start(self, *first: Any) -> None:
        """Start to share; before that, the other end gets `first`, one by one."""
        for value in first:
            self._executor.call_soon(partial(self._send_bytes, pickle.dumps(value)))
        self._sender.start()
        self._receiver.start()
        self._bus.add_link(self)
        self._services.start()

    def audience_changed(
        self, topic: str, msg_type: type, channel: Channel, profile: QoSProfile | None
    ) -> None:
        """Tell the other end which topics are wanted here."""
        if self._wanted_here.get((topic, channel)) == profile:
            return
        if profile is None:
            del self._wanted_here[topic, channel]
        else:
            self._wanted_here[topic, channel] = profile
        self._send_soon("want", topic, msg_type, channel, profile)

    def send_record(self, level: int, text: str, *, is_chosen: bool = False) -> None:
        """Ask the other end to log a text.

        While it is slower than the logging here, the newest records are left out and
        counted. Errors have as much room again.

        Args:
            level: A level of the standard library's `logging`.
            text: The text.
            is_chosen: Whether a level that was set here has let it pass, so that the other end's
                level does not count.
        """
        room = _MANY_RECORDS if level < logging.ERROR else 2 * _MANY_RECORDS
        with self._record_lock:
            if self._records_waiting >= room:
                self._records_left_out += 1
                return
            self._records_waiting += 1
        self._executor.call_soon(partial(self._send_record, level, text, is_chosen))

    def close(self) -> None:
        """Close the link: data on its way has half a second to be sent or received. Idempotent."""
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
        self._services.close()
        for subscription in self._wanted_there.values():
            self._bus.remove_subscription(subscription)
        self._wanted_there.clear()

    def _thread(self, what: str, target: Callable[[], None]) -> threading.Thread:
        return background_thread(target, f"link-{self._name}-{what}")

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
        if reason := self._try_send(*values):
            self._report(reason)

    def _try_send(self, *values: Any) -> str:
        """Send the values; return the reason if that cannot be done."""
        try:
            data = pickle.dumps(values, pickle.HIGHEST_PROTOCOL)
        except Exception as error:
            return f"cannot send {values[0]} {values[1]}: {_text(error)}"
        if len(data) > _MOST_BYTES:
            return f"cannot send a message of {len(data)} bytes: the most is {_MOST_BYTES}"
        self._send_bytes(data)
        return ""

    def _send_bytes(self, data: bytes) -> None:
        try:
            self._connection.send_bytes(data)
        except OSError:
            # The other end is gone; whoever started it says so.
            self._ending = True

    def _send_record(self, level: int, text: str, is_chosen: bool) -> None:
        with self._record_lock:
            self._records_waiting -= 1
            left_out, self._records_left_out = self._records_left_out, 0
        text = f"{text} ... {left_out} more records" if left_out else text
        self._send("record", level, text, is_chosen)

    # On the receiving thread.

    def _receive_all(self) -> None:
        try:
            while self._take(self._connection.recv_bytes(_MOST_BYTES)):
                pass
        except (EOFError, OSError):
            # The other end is gone, and whoever started it says so; or its bytes are no message.
            if not self._connection.closed and not self._connection.readable:
                self._unreadable(f"it announces a message of more than {_MOST_BYTES} bytes")
        finally:
            # Nobody needs to wait for answers of the other end any more.
            self._services.close()

    def _take(self, data: bytes) -> bool:
        """Handle a message; return False if nothing more may be received."""
        try:
            what, *values = pickle.loads(data)
            take, kinds = self._kinds[what]
            if len(values) != len(kinds) or not all(map(isinstance, values, kinds)):
                raise TypeError(f"'{what}' with {', '.join(type(v).__name__ for v in values)}")
        except (Exception, SystemExit) as error:
            return self._unreadable(f"what it sends cannot be read: {_text(error)}")
        try:
            take(*values)
        except Exception as error:
            # Such as a topic that has another type here.
            self._report(f"cannot take what it sends: {_text(error)}")
        return True

    def _unreadable(self, why: str) -> bool:
        """Report unreadable data; return True if the next message may be better."""
        if self._on_fault is None:
            self._report(why)
            return True
        self._on_fault(why)
        return False

    def _take_message(self, topic: str, channel: Channel, message: Any) -> None:
        self._bus.deliver_from(self, topic, channel, message)

    def _take_record(self, level: int, text: str, is_chosen: bool) -> None:
        if self._on_record is not None:
            self._on_record(level, text, is_chosen)

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

    def _report(self, why: str) -> None:
        self._logger.log_throttle(f"{self._name}: {why}", _REPORT_S, "ERROR")


def _text(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"


def _shut(end: socket.socket, how: int = socket.SHUT_RDWR) -> None:
    try:
        end.shutdown(how)
    except OSError:
        # The other end has gone first.
        pass
