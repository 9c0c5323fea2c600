"""The transitions of a lifecycle node: one at a time, each with its callback.

The node has the callbacks, and `last_error` for their reasons.
"""

import threading
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Protocol

from rosbase.clock import Clock
from rosbase.entries.conductor import conductor_of
from rosbase.errors import ServiceStoppedError, TransitionNotAvailableError
from rosbase.lifecycle import CALLBACKS, CallbackReturn, Machine, State, TransitionEvent
from rosbase.logger import RosbaseLogger

if TYPE_CHECKING:
    from rosbase.roles.transition_entrance import TransitionEntrance

__all__ = ["Transitions"]


class _Node(Protocol):
    """A lifecycle node, which also has the methods in `CALLBACKS`."""

    logger: RosbaseLogger
    last_error: BaseException | None

    @property
    def _prefix(self) -> str:
        """Beginning of its lines in the log."""
        ...


class Transitions:
    """Moves the machine of one node, and calls the node back."""

    def __init__(self, node: _Node, machine: Machine, clock: Clock) -> None:
        """Prepare for a node, in the state of its machine."""
        self._node = node
        self._machine = machine
        self._clock = clock
        self._lock = threading.Lock()
        self._thread: int | None = None
        self._since_ns: int | None = None
        self._interrupt: BaseException | None = None
        self._listeners: list[Callable[[TransitionEvent], object]] = []
        self._entrance = self._make_entrance()

    @property
    def is_on_this_thread(self) -> bool:
        """Whether the caller is within a transition, as a callback is."""
        return self._thread == threading.get_ident()

    def describe(self) -> str:
        """Say which transition runs, and since when; empty if none does."""
        since_ns = self._since_ns
        if since_ns is None:
            return ""
        seconds = (self._clock.monotonic_ns() - since_ns) / 1e9
        return f"busy: {self._machine.state.label} since {seconds:.0f} s"

    def add_listener(self, listener: Callable[[TransitionEvent], object]) -> None:
        """Call `listener(event)` after each step, on the thread that takes it."""
        self._listeners.append(listener)

    def wait_for_others(self, patience_s: float) -> bool:
        """Wait for a transition on another thread; return False if it still runs."""
        if self.is_on_this_thread:
            return True
        if self._entrance is None or not self._entrance.is_inside:
            return self._wait(patience_s)
        # Nobody drives it while this thread runs the program, unless it waits in a callback.
        return self._wait(0) or self._entrance.let_others(partial(self._wait, patience_s))

    def _wait(self, patience_s: float) -> bool:
        if not self._lock.acquire(timeout=patience_s):
            return False
        self._lock.release()
        return True

    def request(self, transition_id: int, label: str) -> CallbackReturn:
        """Run the transition of that label, or else of that id; return the callback's result.

        Raises:
            TransitionNotAvailableError: It does not start at this state, or another one is
                running.
        """
        drive = partial(self._drive, lambda: self._machine.request(transition_id, label))
        if self._entrance is None or self._entrance.is_inside:
            return drive()
        return self._entrance.request(transition_id, label, drive)

    def raise_error(self, error: BaseException) -> CallbackReturn:
        """Run `on_error` for a fault outside of any transition; return its result.

        Raises:
            TransitionNotAvailableError: The node is finalized, or a transition is running.
        """
        node = self._node

        def begin() -> TransitionEvent:
            previous = self._machine.state
            event = self._machine.raise_error()
            node.last_error = error
            node.logger.error(f"{node._prefix}error in {previous.label}: {_described(error)}")
            return event

        if self._entrance is None or self._entrance.is_inside:
            return self._drive(begin)
        return self._entrance.raise_error(error, partial(self._drive, begin))

    def _make_entrance(self) -> "TransitionEntrance | None":
        conductor = conductor_of(self._clock)
        if conductor is None:
            return None
        from rosbase.roles.transition_entrance import TransitionEntrance

        return TransitionEntrance(conductor, type(self._node).__qualname__, self)

    def _drive(self, begin: Callable[[], TransitionEvent]) -> CallbackReturn:
        if not self._lock.acquire(blocking=False):
            raise TransitionNotAvailableError(self.describe() or "busy")
        self._thread = threading.get_ident()
        self._since_ns = self._clock.monotonic_ns()
        # What ends the program is passed on once the machine has come to rest.
        self._interrupt = None
        node = self._node
        known_error = node.last_error
        try:
            event = begin()
            self._note(event)
            answer = self._call_back()
            self._note(self._machine.finish(answer))
            if answer is CallbackReturn.FAILURE:
                reason = self._reason(known_error)
                state = self._machine.state.label
                node.logger.error(
                    f"{node._prefix}{event.transition.label} failed, now {state}: {reason}"
                )
            if self._machine.state is State.ERRORPROCESSING:
                self._note(self._machine.finish(self._call_back()))
            interrupt = self._interrupt
        finally:
            self._thread = self._since_ns = None
            self._lock.release()
        if interrupt is not None:
            raise interrupt
        return answer

    def _call_back(self) -> CallbackReturn:
        """Run the callback of the current state; return its result."""
        node = self._node
        name, known_error = CALLBACKS[self._machine.state], node.last_error
        try:
            answer = getattr(node, name)(self._machine.previous_state)
        except BaseException as error:
            node.last_error = error
            self._report(name, error)
            return CallbackReturn.ERROR
        if answer is CallbackReturn.ERROR:
            node.logger.error(f"{node._prefix}{name} answered ERROR: {self._reason(known_error)}")
        if isinstance(answer, CallbackReturn):
            return answer
        node.last_error = TypeError(f"{name} must return a CallbackReturn, not {answer!r}")
        node.logger.error(f"{node._prefix}{node.last_error}")
        return CallbackReturn.ERROR

    def _reason(self, known_error: BaseException | None) -> object:
        """Return the reason that a callback left in `last_error`."""
        last_error = self._node.last_error
        is_new = last_error is not known_error and last_error is not None
        return last_error if is_new else "no reason (set last_error to give one)"

    def _note(self, event: TransitionEvent) -> None:
        for listener in self._listeners:
            try:
                listener(event)
            except BaseException as error:
                self._report("a transition listener", error)

    def _report(self, who: str, error: BaseException) -> None:
        if isinstance(error, Exception) and not isinstance(error, ServiceStoppedError):
            node = self._node
            node.logger.error(f"{node._prefix}{who} raised {_described(error)}", exc_info=error)
        else:
            self._interrupt = self._interrupt or error


def _described(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
