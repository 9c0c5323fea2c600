"""rclpy's executor on its own thread: it receives messages, and hands them to the main loop.

So the main loop keeps its rate and its cost whatever rclpy does. Services are answered while the
main thread is busy. The EventsExecutor of rclpy would cost a third for each message, but it cannot
run the coroutines for such answers. It serves only what rosbase has created on the node; for the
rest there is a NativeExecutor.
"""

import threading
from collections.abc import Callable
from typing import Any

from rclpy.executors import SingleThreadedExecutor

from rosbase import SystemClock, background_thread
from rosbase_ros2.deadline import Deadline
from rosbase_ros2.native import NativeExecutor
from rosbase_ros2.shared_node import SharedNode

__all__ = ["Spinner"]

# It is woken by a task.
_LONG_S = 3600.0
_LOOK_S = 0.2
# A program ends within two seconds, whatever a callback of rclpy's is busy with.
_CALL_S = 0.1


class Spinner:
    """Spins one rclpy node until it is closed."""

    def __init__(
        self,
        context: Any,
        node: SharedNode,
        report: Callable[[BaseException], object],
        on_context_end: Callable[[], object],
    ) -> None:
        """Start to spin.

        Args:
            context: The node's rclpy context.
            node: The rclpy node.
            report: Called with the exception of a foreign callback, on the thread that has run
                it; spinning goes on.
            on_context_end: Called on this thread when the context ends first.
        """
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(node.own)
        self._native = NativeExecutor(context, node, self.executor.wake, report)
        self._context = context
        self._node = node
        self._report = report
        self._on_context_end = on_context_end
        self._patience_s = _LONG_S
        self._look: Callable[[], object] | None = None
        self._look_due_ns = 0
        self._clock = SystemClock()
        self._has_begun_to_end = self._ending = False
        self._thread = background_thread(self._run, "rclpy")
        self._thread.start()

    @property
    def is_current_thread(self) -> bool:
        """Whether the caller is a callback of rclpy, of either side of the node."""
        return threading.current_thread() is self._thread or self._native.is_current_thread

    def call(self, function: Callable[[], object], patience_s: float = _CALL_S) -> None:
        """Run a function between two callbacks, and wait a moment for it."""
        if threading.current_thread() is self._thread or not self._thread.is_alive():
            function()
            return
        done = threading.Event()

        def run() -> None:
            try:
                function()
            finally:
                done.set()

        self.executor.create_task(run)
        done.wait(patience_s)

    def look_now_and_then(self, look: Callable[[], object]) -> None:
        """Call `look` several times a second, on this thread, from now on."""

        def begin() -> None:
            self._look, self._patience_s = look, _LOOK_S

        self.call(begin)

    def look_soon(self, look: Callable[[], object]) -> None:
        """Call `look` once, on this thread, without waiting for it."""
        if self._thread.is_alive():
            self.executor.create_task(look)

    def begin_end(self) -> None:
        """Let the threads end, each after its callback, without waiting for them.

        What is ready goes first, such as the answer to a client that asked for the last
        transition.
        """
        if self._has_begun_to_end:
            return
        self._has_begun_to_end = True
        self._native.begin_end()
        if self._thread.is_alive():
            # rclpy runs the newest task first, and then all others that are ready. A task that
            # this one creates comes after them.
            self.executor.create_task(lambda: self.executor.create_task(self._end))

    def close(self, deadline: Deadline) -> bool:
        """End the threads; return whether all have ended in time."""
        self.begin_end()
        if threading.current_thread() is not self._thread:
            self._thread.join(deadline.left_s)
        # If a callback hangs, the thread ends after it.
        self._ending = True
        has_native_ended = self._native.close(deadline)
        if self._thread.is_alive():
            return False
        self.executor.remove_node(self._node.own)
        self.executor.shutdown()
        return has_native_ended

    def _run(self) -> None:
        # A program can end the context itself: nothing comes in then.
        while not self._ending and self._context.ok():
            try:
                self.executor.spin_once(timeout_sec=self._patience_s)
            except Exception as error:
                if self._context.ok():
                    self._report(error)
            if self._look is not None:
                self._look_if_due(self._look)
        if not self._ending:
            self._on_context_end()

    def _look_if_due(self, look: Callable[[], object]) -> None:
        now_ns = self._clock.monotonic_ns()
        if now_ns >= self._look_due_ns:
            self._look_due_ns = now_ns + int(_LOOK_S * 1e9)
            look()

    def _end(self) -> None:
        self._ending = True
