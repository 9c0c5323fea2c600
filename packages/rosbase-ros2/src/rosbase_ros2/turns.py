"""Turns of rclpy's tasks, and whether one of them may have missed what it waits for.

A coroutine of rclpy is not told when what it awaits is there: its executor resumes it after
everything that may have brought it, and looks whether it goes on. A task that runs just then cannot
be resumed. So an event that comes during a turn is remembered, and looked for again after it.
"""

import threading
from typing import Any
from weakref import WeakSet

__all__ = ["Turns"]


class Turns:
    """The tasks that run or wait. Use it from any thread.

    The thread that looks for tasks to resume calls `begin` for each. It must look again whenever
    one of the other methods says so, and after each event from elsewhere.
    """

    def __init__(self) -> None:
        """Start without a task."""
        # The number of events that had come when the turn of a task began.
        self._running: dict[Any, int] = {}
        # Weak: nobody says here that a task has been cancelled.
        self._waiting: WeakSet[Any] = WeakSet()
        self._have_waited = False
        self._events = 0
        # A finalizer or a signal handler may create something on the node, in the middle of this.
        self._lock = threading.RLock()

    def note_event(self) -> None:
        """Note something that tasks may wait for. Look for tasks to resume after it."""
        with self._lock:
            self._events += 1

    def begin(self, task: Any) -> bool:
        """Begin a turn of a task; return False if another one has not ended."""
        with self._lock:
            if task in self._running:
                return False
            self._running[task] = self._events
            return True

    def end(self, task: Any, *, is_over: bool) -> bool:
        """End the turn of a task, which can be resumed from now on.

        Args:
            task: The task.
            is_over: Whether it has ended, and does not wait.

        Returns:
            Whether to look for tasks to resume: this one, if something has happened during its
            turn, or others, which may wait for what it has done.
        """
        with self._lock:
            is_behind = self._running.pop(task) != self._events
            if is_over and not self._have_waited:
                # As in most programs: this is on the way of every message.
                self._events += 1
                return False
            is_first = task not in self._waiting
            self._waiting.discard(task)
            has_others = False
            if is_over or is_first:
                # A later turn that ends with waiting again has most likely done nothing. If it
                # counted, two tasks that wait would resume each other for ever.
                self._events += 1
                has_others = len(self._waiting) > 0
            if not is_over:
                self._have_waited = True
                self._waiting.add(task)
            return has_others or (is_behind and not is_over)
