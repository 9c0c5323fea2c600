"""Raise an exception in user code that blocks the main thread.

Only a signal handler can do that: it also ends a `sleep`, an `input()` or a wait for a lock, which
`_thread.interrupt_main` does not. So a thread sends the main thread SIGURG, and the handler
raises. Processes that do not handle SIGURG ignore it.
"""

import _thread
import signal
import sys
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any, TypeAlias

from rosbase.clock import SystemClock

__all__ = ["Defer", "Interrupt", "is_user_code"]

# Windows has neither this signal nor `pthread_kill`: there, blocking code is waited for.
_KNOCK = getattr(signal, "SIGURG", None)
_RETRY_S = 0.01
_REPEAT_S = 0.5
_DRAIN_TRIES = 100
# Callbacks of weak references in the standard library. Python prints what is raised there, with a
# traceback, and goes on.
_CALLBACKS = {
    ("_weakrefset", "_remove"),
    ("importlib._bootstrap", "cb"),
    ("importlib._bootstrap", "remove"),
    ("weakref", "remove"),
}
# Exceptions of an own clean-up, each raised while the one before was handled.
_MOST_CONTEXTS = 20

Defer: TypeAlias = Callable[[Callable[[], object]], object]


class Interrupt:
    """Raises in user code of the main thread, once that is due, until it is disarmed.

    It never raises in rosbase itself, because that could leave it in a broken state. While
    rosbase runs, it tries again 10 ms later. Where user code waits in rosbase, such as in
    `spin_once`, the exception is raised there by a deferred call.
    """

    def __init__(
        self, make_error: Callable[[FrameType | None], BaseException], defer: Defer | None = None
    ) -> None:
        """Prepare nothing yet.

        Args:
            make_error: Makes the exception, for the frame in which it is raised.
            defer: Queues a call for the spinning thread: `Backend.call_soon`.
        """
        self._make_error = make_error
        self._defer = defer
        self._clock = SystemClock()
        self._due_ns: int | None = None
        self._is_deferred = self._is_knocking = self._has_thread = self._repeats = False
        self._is_prepared = False
        self._raised: BaseException | None = None
        self._handler_before: Any = None
        # Held while the thread knocks: after `disarm`, no knock is on its way.
        self._knock_lock = threading.Lock()

    def arm(self, delay_s: float, *, repeats: bool) -> None:
        """Raise after that time, and with `repeats` again every half second.

        Call it on the main thread or in its signal handlers; on other threads only after
        `prepare`.
        """
        self._repeats = repeats
        self._due_ns = self._clock.monotonic_ns() + int(delay_s * 1e9)
        self._is_deferred = False
        # Armed anew, it raises even where the exception before is being handled.
        self._raised = None
        if self._has_thread or _KNOCK is None:
            return
        self._has_thread = True
        self.prepare()
        # Not `threading.Thread`, whose start takes locks that the interrupted code may hold.
        _thread.start_new_thread(self._knock_until_disarmed, ())

    def prepare(self) -> None:
        """Let other threads arm it, until it is disarmed. Call it on the main thread."""
        if not self._is_prepared and _KNOCK is not None:
            self._is_prepared = True
            self._handler_before = signal.signal(_KNOCK, self._handle)

    def arm_from_thread(self, delay_s: float) -> None:
        """Arm it once, on any thread, if it has been prepared and not disarmed since."""
        with self._knock_lock:
            if self._is_prepared and self._due_ns is None:
                self.arm(delay_s, repeats=True)

    def disarm(self) -> None:
        """Stop raising. Call it on the main thread, outside of a signal handler."""
        self._due_ns = None
        if not self._is_prepared or _KNOCK is None:
            return
        with self._knock_lock:
            # Another thread may have armed it meanwhile.
            self._due_ns = self._raised = None
            self._has_thread = self._is_prepared = False
        # A knock that has been sent is handled before the handler is taken away.
        for _ in range(_DRAIN_TRIES):
            if not self._is_knocking:
                break
            self._clock.sleep(0.001)
        signal.signal(_KNOCK, self._handler_before)

    def raise_in(self, frame: FrameType | None) -> None:
        """Raise if it is due and the frame is user code. Called by signal handlers."""
        if self._due_ns is None or self._clock.monotonic_ns() < self._due_ns:
            return
        if _is_callback(frame):
            return
        if not is_user_code(frame):
            if self._defer is not None and not self._is_deferred:
                self._is_deferred = True
                self._defer(self._raise_if_due)
            return
        self._raise(frame)

    def _raise_if_due(self) -> None:
        self._is_deferred = False
        if self._due_ns is not None and self._clock.monotonic_ns() >= self._due_ns:
            self._raise(None)

    def _raise(self, frame: FrameType | None) -> None:
        # Code that catches it and goes on is interrupted again; its own clean-up is not.
        again_ns = self._clock.monotonic_ns() + int(_REPEAT_S * 1e9)
        self._due_ns = again_ns if self._repeats else None
        if _is_handled(self._raised):
            return
        self._raised = self._make_error(frame)
        raise self._raised

    def _handle(self, signum: int, frame: FrameType | None) -> None:
        self._is_knocking = False
        self.raise_in(frame)

    def _knock_until_disarmed(self) -> None:
        main = threading.main_thread().ident
        assert main is not None
        assert _KNOCK is not None
        while True:
            self._clock.sleep(_RETRY_S)
            with self._knock_lock:
                if not self._has_thread:
                    return
                due_ns = self._due_ns
                if due_ns is not None and self._clock.monotonic_ns() >= due_ns:
                    self._is_knocking = True
                    signal.pthread_kill(main, _KNOCK)


def _is_handled(error: BaseException | None) -> bool:
    """Return whether this thread is in an `except`, `finally` or `with` because of the error."""
    handled = sys.exc_info()[1] if error is not None else None
    for _ in range(_MOST_CONTEXTS):
        if handled is None or handled is error:
            break
        handled = handled.__context__
    return handled is not None and handled is error


def _is_callback(frame: FrameType | None) -> bool:
    """Return whether an exception that is raised in the frame would be lost."""
    if frame is None:
        return False
    return (frame.f_globals.get("__name__"), frame.f_code.co_name) in _CALLBACKS


def is_user_code(frame: FrameType | None, *, innermost: bool = False) -> bool:
    """Return whether the innermost frame outside the standard library is user code, not rosbase.

    Args:
        frame: Frame to begin with.
        innermost: Whether to look only at this frame.
    """
    while frame is not None:
        package = str(frame.f_globals.get("__name__", "")).partition(".")[0]
        if package == "rosbase" or package.startswith("rosbase_"):
            return False
        if package not in sys.stdlib_module_names:
            return True
        frame = None if innermost else frame.f_back
    return False
