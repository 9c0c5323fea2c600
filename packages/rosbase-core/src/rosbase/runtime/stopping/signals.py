"""Handling of SIGINT, SIGTERM and SIGHUP while a program runs.

The first request asks for the stop; user code that has not returned after half a second gets
KeyboardInterrupt. The second request raises it at once; within the clean-up it ends only the
blocking step. The third request ends the process. Signals within a second count as one request,
which is called a wish in the code.
"""

import atexit
import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import FrameType
from typing import Any

from attrs import frozen

from rosbase.clock import SystemClock
from rosbase.runtime.signal_masks import STOP_SIGNALS
from rosbase.runtime.stopping.interrupt import Defer, Interrupt
from rosbase.runtime.stopping.native import is_same_handler, read_handler, write_handler
from rosbase.runtime.stopping.wishes import Wishes

__all__ = ["StopSignals", "stop_on_signals"]

_PATIENCE_S = 0.5
_QUIET_NS = 1_000_000_000
_FORCE_WISHES = 3

# Windows has no SIGHUP.
_HANGUP = getattr(signal, "SIGHUP", None)

_clock = SystemClock()


class StopSignals:
    """Requests to stop one run, from its first step to the end of its clean-up."""

    def __init__(self, request_stop: Callable[[], object], defer: Defer | None = None) -> None:
        """Prepare a run.

        Args:
            request_stop: Asks for the stop. It runs in a signal handler, so it must be quick and
                take no locks.
            defer: Queues a call for the spinning thread, from a signal handler.
        """
        self._request_stop = request_stop
        self._wishes = Wishes()
        self._interrupt = Interrupt(lambda frame: KeyboardInterrupt(), defer)
        self._cleans_up = False
        self._ended_with_a_child = False

    @property
    def was_asked(self) -> bool:
        """Whether a signal has asked for the stop."""
        return self._wishes.count > 0

    @property
    def came_from_outside(self) -> bool:
        """Whether a signal, or the end of a required child, has asked for the stop."""
        return self.was_asked or self._ended_with_a_child

    def prepare_for_children(self) -> None:
        """Let the end of a required child interrupt the main thread, if this is the main thread."""
        if threading.current_thread() is threading.main_thread():
            self._interrupt.prepare()

    def child_has_ended(self) -> None:
        """Ask for the stop because a required child has ended. Call it from any thread.

        Blocking user code is interrupted as by the first request.
        """
        self._ended_with_a_child = True
        self._request_stop()
        self._interrupt.arm_from_thread(_PATIENCE_S)

    def begin_clean_up(self) -> None:
        """Stop the interruption that the first request started."""
        self._cleans_up = True
        self._interrupt.disarm()

    def begin_step(self) -> None:
        """Begin a step of the clean-up: a request for the step before is over."""
        self._interrupt.disarm()

    def end(self) -> None:
        """Stop all interruptions."""
        self._interrupt.disarm()

    def handle(self, signum: int, frame: FrameType | None) -> None:
        """Handle a signal. For `signal.signal`."""
        if not self._wishes.add(_clock.monotonic_ns()):
            return
        if self._wishes.count >= _FORCE_WISHES:
            os._exit(128 + signum)
        self._request_stop()
        if self._wishes.count > 1:
            self._interrupt.arm(0.0, repeats=not self._cleans_up)
            self._interrupt.raise_in(frame)
        elif not self._cleans_up:
            self._interrupt.arm(_PATIENCE_S, repeats=True)


@contextmanager
def stop_on_signals(
    request_stop: Callable[[], object],
    defer: Defer | None = None,
    *,
    yields_to_outer: bool = False,
) -> Iterator[StopSignals]:
    """Let SIGINT, SIGTERM and SIGHUP ask for a stop, as long as the context lasts.

    A SIGHUP that is ignored, as under nohup, stays ignored. After the context, the earlier
    handlers are restored. If a signal has asked for the stop, further signals are first
    ignored for a second. Outside of the main thread, where Python delivers no signals, nothing
    changes.

    Args:
        request_stop: Passed to `StopSignals`.
        defer: Passed to `StopSignals`.
        yields_to_outer: Whether to change nothing within another such context. Afterwards,
            handlers of C libraries are restored too. After a run, those would belong to a library
            that has ended.
    """
    stop = StopSignals(request_stop, defer)
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or (yields_to_outer and _handlers.active):
        yield stop
        return
    before = _handlers.install(stop)
    try:
        yield stop
    finally:
        _handlers.remove(before, is_quiet=stop.was_asked, is_native_kept=yields_to_outer)
        # Only now: until then a signal may still arm it.
        stop.end()


class _Handlers:
    """Keeps track of which handlers are installed in this process. For the main thread only."""

    def __init__(self) -> None:
        self.active = 0
        """Number of active contexts."""
        self._quiet_until_ns = 0
        self._after_quiet: Mapping[int, Any] = {}

    def install(self, stop: StopSignals) -> "_Before":
        """Install the handlers of a run; return the earlier handlers."""
        self._end_quiet()
        self.active += 1
        numbers = [
            number
            for number in STOP_SIGNALS
            if number != _HANGUP or signal.getsignal(number) is not signal.SIG_IGN
        ]
        native = {number: read_handler(number) for number in numbers}
        handlers = {number: signal.signal(number, stop.handle) for number in numbers}
        return _Before(handlers, native, {number: read_handler(number) for number in numbers})

    def remove(self, before: "_Before", *, is_quiet: bool, is_native_kept: bool) -> None:
        """Restore the earlier handlers, at once or after a second without signals."""
        self.active -= 1
        if is_quiet:
            self._quiet_until_ns = _clock.monotonic_ns() + _QUIET_NS
        if not is_quiet and not self._after_quiet:
            before.put_back(is_native_kept=is_native_kept)
            return
        self._after_quiet = before.handlers
        _set(dict.fromkeys(before.handlers, self._ignore_for_now))

    def ignore_to_the_end(self) -> None:
        """Keep Python from restoring the system's handlers when it ends."""
        if self._after_quiet and _clock.monotonic_ns() < self._quiet_until_ns:
            _set(dict.fromkeys(self._after_quiet, signal.SIG_IGN))

    def _end_quiet(self) -> None:
        if self._after_quiet:
            _set(self._after_quiet)
            self._after_quiet = {}

    def _ignore_for_now(self, signum: int, frame: FrameType | None) -> None:
        if _clock.monotonic_ns() < self._quiet_until_ns:
            return
        handler = self._after_quiet.get(signum)
        self._end_quiet()
        if callable(handler):
            handler(signum, frame)
        elif handler is signal.SIG_DFL:
            os.kill(os.getpid(), signum)


@frozen
class _Before:
    """Handlers from before a run."""

    handlers: Mapping[int, Any]
    """Handlers that Python knows."""
    native: Mapping[int, bytes]
    """Handlers that the system knows."""
    ours: Mapping[int, bytes]
    """Handlers of a run, as the system knows them."""

    def put_back(self, *, is_native_kept: bool) -> None:
        """Restore the handlers; keep one that a library has installed during the run."""
        if not is_native_kept:
            _set(self.handlers)
            return
        now = {number: read_handler(number) for number in self.handlers}
        _set(self.handlers)
        for number, handler in now.items():
            is_ours = is_same_handler(handler, self.ours[number])
            write_handler(number, self.native[number] if is_ours else handler)


def _set(handlers: Mapping[int, Any]) -> None:
    for number, handler in handlers.items():
        # None: a handler that Python did not install, and cannot put back.
        if handler is not None:
            signal.signal(number, handler)


_handlers = _Handlers()
atexit.register(_handlers.ignore_to_the_end)
