"""Find out whether a program is ready, on a thread of its own, while somebody waits for it."""

import threading
from collections.abc import Callable, Iterable
from typing import Protocol

from rosbase.launcher.description import Condition
from rosbase.runtime.signal_masks import background_thread

__all__ = ["ASKED", "Readiness", "ReadinessWatch"]

_PERIOD_S = 0.1
ASKED = ("lifecycle active", "handshake")
"""Conditions for which a program is asked."""


class Readiness(Protocol):
    """Tells whether a running program meets a condition."""

    def meets(self, key: str, condition: Condition) -> bool:
        """Return whether a program meets `lifecycle active` or `handshake` by now.

        Called about ten times a second on a thread of its own, which it may block for a second.

        Args:
            key: Key of the program.
            condition: The condition.
        """
        ...


class ReadinessWatch:
    """Asks again and again about the conditions that somebody waits for."""

    def __init__(self, readiness: Readiness, on_ready: Callable[[str, Condition], object]) -> None:
        """Prepare the thread.

        Args:
            readiness: Answers the questions.
            on_ready: Called on this thread when a program meets a condition.
        """
        self._readiness = readiness
        self._on_ready = on_ready
        self._wanted: frozenset[tuple[str, Condition]] = frozenset()
        self._changed = threading.Condition()
        self._is_closed = False
        self._thread = background_thread(self._run, "readiness")

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def seek(self, wanted: Iterable[tuple[str, Condition]]) -> None:
        """Ask about these conditions from now on, and about no others."""
        asked = frozenset(pair for pair in wanted if pair[1].kind in ASKED)
        if asked != self._wanted:
            with self._changed:
                self._wanted = asked
                self._changed.notify()

    def close(self) -> None:
        """End the thread. Idempotent."""
        with self._changed:
            self._is_closed = True
            self._changed.notify()
        if self._thread.ident is not None:
            self._thread.join()

    def _run(self) -> None:
        while True:
            with self._changed:
                # While nobody waits, it sleeps.
                self._changed.wait(_PERIOD_S if self._wanted else None)
                if self._is_closed:
                    return
                wanted = self._wanted
            for key, condition in wanted:
                if self._readiness.meets(key, condition):
                    self._on_ready(key, condition)
