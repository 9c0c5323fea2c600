"""Threads for what the program itself creates on an rclpy node: services, actions, tf2.

rosbase's own thread does not serve it, so nothing that it does stops what rosbase subscribes to.
One thread waits, and others run the callbacks. Callback groups decide which may run at the same
time, as in rclpy's MultiThreadedExecutor: by default, one after the other. Without such
entities there is no thread.

A program may spin the node with an executor of its own too, as `rclpy.spin_until_future_complete`
does: a guest. It is told of each callback that has run here, and returns as if it had run it.
"""

import math
import threading
from collections import deque
from collections.abc import Callable
from typing import Any
from weakref import WeakKeyDictionary

from attrs import define
from rclpy.executors import (
    ConditionReachedException,
    Executor,
    ExternalShutdownException,
    ShutdownException,
    TimeoutException,
    TimeoutObject,
)

from rosbase import SystemClock, background_thread
from rosbase_ros2.deadline import Deadline
from rosbase_ros2.shared_node import SharedNode
from rosbase_ros2.turns import Turns
from rosbase_ros2.workers import Workers

__all__ = ["NativeExecutor"]

# Guests are woken this often: one that waits on the main thread handles no signal.
_GUEST_S = 0.2
_RETRY_S = 0.1
# For a program that runs as many callbacks at once, and waits in each for another one.
_MOST_WORKERS = 32


class NativeExecutor(Executor):  # type: ignore[misc]  # rclpy is Any
    """Executor of the program's side of a node, which spins by itself as soon as it is needed."""

    def __init__(
        self,
        context: Any,
        node: SharedNode,
        wake_own: Callable[[], object],
        report: Callable[[BaseException], object],
    ) -> None:
        """Take over the program's side of a node.

        Args:
            context: The node's rclpy context.
            node: The node. This executor becomes its `executor`.
            wake_own: Called when something was created or destroyed on the node.
            report: Called with the exception of a callback, on the thread that has run it.
        """
        super().__init__(context=context)
        self._node = node
        self._wake_own = wake_own
        self._report = report
        self._machine = SystemClock()
        self._guests = Guests(node)
        self._workers = Workers("rclpy-native-worker", _MOST_WORKERS)
        self._turns = Turns()
        self._thread: threading.Thread | None = None
        self._start_lock = threading.Lock()
        self._is_closed = False
        # Set to return from waiting; read by the thread that waits.
        self._has_news = False
        self._finished = 0
        self._finish = threading.Condition()
        self.add_node(node.native)
        node.native_executor = self
        self.wake()

    @property
    def is_current_thread(self) -> bool:
        """Whether the caller runs on one of these threads."""
        return self._workers.are_current_thread

    def wake(self) -> None:
        """Look at the node again, because something was created or destroyed on it."""
        self._node.own.refresh()
        self._node.native.refresh()
        self._wake_own()
        self._turns.note_event()
        super().wake()
        if not self._node.native.is_empty:
            self._start()

    def create_task(self, callback: Any, *arguments: Any, **options: Any) -> Any:
        """Run a function or a coroutine on one of the threads; return its future."""
        self._turns.note_event()
        task = super().create_task(callback, *arguments, **options)
        self._start()
        return task

    def welcome(self, guest: Any) -> None:
        """Note that an executor of the program's spins the node. Call it from any thread."""
        if guest is not self:
            self._guests.welcome(guest)
            self._start()
            self._tell()

    def begin_end(self) -> None:
        """Let the threads end, each after its callback."""
        with self._start_lock:
            has_begun, self._is_closed = self._is_closed, True
        if not has_begun:
            self._tell()

    def close(self, deadline: Deadline) -> bool:
        """End the threads; return whether all have ended in time."""
        self.begin_end()
        if self._thread is not None and not self.is_current_thread:
            self._thread.join(deadline.left_s)
        if not self._workers.join(deadline):
            return False
        if self._thread is not None and self._thread.is_alive():
            return False
        self.remove_node(self._node.native)
        self.shutdown()
        return True

    # For a program that spins `node.executor`: it waits for what the threads do.

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait until a callback has run, or the node ends. Without a timeout, wait for ever."""
        patience_s = math.inf if timeout_sec is None or timeout_sec < 0 else timeout_sec
        start_ns = self._machine.monotonic_ns()
        with self._finish:
            before = self._finished
            while self._finished == before and not self._is_closed and self._context.ok():
                left_s = patience_s - (self._machine.monotonic_ns() - start_ns) / 1e9
                if left_s <= 0:
                    return
                self._finish.wait(min(left_s, _GUEST_S))

    def spin_once_until_future_complete(
        self, future: Any, timeout_sec: float | TimeoutObject | None = None
    ) -> None:
        """Wait until the future is done, or for a moment."""
        if isinstance(timeout_sec, TimeoutObject):
            timeout_sec = timeout_sec.timeout
        with self._finish:
            if not future.done():
                self._finish.wait(_GUEST_S if timeout_sec is None else min(timeout_sec, _GUEST_S))

    def _start(self) -> None:
        with self._start_lock:
            if self._thread is None and not self._is_closed:
                self._node.note_native()
                self._thread = background_thread(self._run, "rclpy-native")
                self._thread.start()

    def _tell(self) -> None:
        """Have the waiting thread look at everything again."""
        self._has_news = True
        super().wake()

    def _run(self) -> None:
        try:
            while not self._is_closed and self._context.ok():
                self._has_news = False
                has_guests = self._guests.attend(self._finished)
                try:
                    self._take_turn(_GUEST_S if has_guests else None)
                except Exception as error:
                    if self._context.ok():
                        self._report(error)
                        # Waiting itself has failed, which may happen again at once.
                        self._machine.sleep(_RETRY_S)
        finally:
            # After the last call: one that never runs leaves a coroutine that nobody awaits.
            self._workers.end()

    def _take_turn(self, patience_s: float | None) -> None:
        """Wait for a callback, and have it run."""
        try:
            task, _, _ = self.wait_for_ready_callbacks(patience_s, None, self._is_interrupted)
        except (
            ConditionReachedException,
            ExternalShutdownException,
            ShutdownException,
            TimeoutException,
        ):
            return
        # rclpy offers a task again until a thread has begun with it.
        if self._turns.begin(task):
            self._workers.submit(lambda: self._execute(task))

    def _is_interrupted(self) -> bool:
        return self._has_news or self._is_closed

    def _execute(self, task: Any) -> None:
        """Run a task, or a coroutine until it waits."""
        try:
            task()
            error = task.exception() if task.done() else None
        except BaseException as raised:
            error = raised
        is_over = error is not None or task.done() or task.cancelled()
        if self._turns.end(task, is_over=is_over):
            super().wake()
        if error is not None and self._context.ok():
            self._report(error)
        if is_over:
            with self._finish:
                self._finished += 1
                self._finish.notify_all()
            if self._guests:
                self._tell()


@define
class _Guest:
    """News that a guest has got."""

    finished: int = -1
    """Number of callbacks that had run then."""
    nudge: Any = None
    """Task by which it was told."""


class Guests:
    """Executors of the program that spin the node. They find nothing there to serve."""

    def __init__(self, node: SharedNode) -> None:
        """Start without one."""
        self._node = node
        self._arrivals: deque[Any] = deque()
        self._guests: WeakKeyDictionary[Any, _Guest] = WeakKeyDictionary()

    def __bool__(self) -> bool:
        """Return whether there has been one."""
        return bool(self._arrivals or self._guests)

    def welcome(self, executor: Any) -> None:
        """Take a guest. It holds its own locks now, so nothing is asked of it."""
        self._arrivals.append(executor)

    def attend(self, finished: int) -> bool:
        """Tell the guests of callbacks that have run, on the thread that waits.

        Args:
            finished: How many callbacks have run.

        Returns:
            Whether there is a guest.
        """
        while self._arrivals:
            self._guests.setdefault(self._arrivals.popleft(), _Guest())
        is_here = False
        for executor, guest in list(self._guests.items()):
            try:
                if self._node in executor.get_nodes():
                    is_here = True
                    _attend(executor, guest, finished)
            except Exception:
                # It has been shut down.
                self._guests.pop(executor, None)
        return is_here


def _attend(executor: Any, guest: _Guest, finished: int) -> None:
    executor.wake()
    if guest.finished != finished:
        guest.finished = finished
        # One that does not spin is not told twice.
        if guest.nudge is None or guest.nudge.done():
            guest.nudge = executor.create_task(_nothing)


def _nothing() -> None:
    """Do nothing: run to have `spin_once` of an executor return."""
