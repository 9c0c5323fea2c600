"""Look now and then whether services have come or gone, while calls wait for them.

rclpy tells nobody. Without calls, nothing looks.
"""

import threading
from typing import Any, Protocol

from rclpy.clock import Clock as RclpyClock
from rclpy.clock import ClockType

from rosbase_ros2.shared_node import OwnGroup
from rosbase_ros2.spinner import Spinner

__all__ = ["ServiceWatch", "Watched"]

_LOOK_S = 0.05
# A second. To begin and to end costs more than to look.
_MOST_IDLE = 20


class Watched(Protocol):
    """A client."""

    def look(self) -> bool:
        """Look whether the service is there; return whether calls are under way."""
        ...


class ServiceWatch:
    """Watches the services of one node's clients, on the thread of rclpy."""

    def __init__(self, node: Any, spinner: Spinner) -> None:
        """Prepare for the clients of an rclpy node. Nothing looks before `begin`."""
        self._node = node
        self._spinner = spinner
        # Replaced when it changes, because other threads add and remove.
        self._clients: tuple[Watched, ...] = ()
        self._lock = threading.Lock()
        self._is_on = False
        self._idle = 0
        self._timer: Any = None

    def add(self, client: Watched) -> None:
        """Look for a client from now on."""
        with self._lock:
            self._clients = (*self._clients, client)

    def remove(self, client: Watched) -> None:
        """Look for it no more."""
        with self._lock:
            self._clients = tuple(one for one in self._clients if one is not client)

    def begin(self) -> None:
        """Look for some time: a call has begun. Call it from any thread."""
        self._idle = 0
        if not self._is_on:
            with self._lock:
                is_first, self._is_on = not self._is_on, True
            if is_first:
                self._spinner.look_soon(self._start)

    def _start(self) -> None:
        # Not the node's clock, which may be a simulation's.
        clock = RclpyClock(clock_type=ClockType.STEADY_TIME)
        self._timer = self._node.create_timer(_LOOK_S, self._look, OwnGroup(), clock)

    def _look(self) -> None:
        self._idle += 1
        if self._look_at_all():
            self._idle = 0
        if self._idle <= _MOST_IDLE:
            return
        self._node.destroy_timer(self._timer)
        self._is_on = False
        # Whoever has begun a call just before that line relies on this.
        if self._look_at_all():
            self.begin()

    def _look_at_all(self) -> bool:
        is_busy = False
        for client in self._clients:
            is_busy = client.look() or is_busy
        return is_busy
