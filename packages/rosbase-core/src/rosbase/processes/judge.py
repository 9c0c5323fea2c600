"""Decide what follows the end of a child: a restart, the end of the program, or nothing.

This module reads no clock and starts nothing.
"""

from collections.abc import Callable, Iterator

from rosbase.processes.child import ChildProcess, Life
from rosbase.processes.journal import Journal

__all__ = ["Judge"]

_NS_PER_S = 1_000_000_000
# Whoever stops a whole group of processes may come to the manager last.
_HESITATION_NS = 500_000_000


class Judge:
    """Decides about ended children, until the program itself is asked to end.

    A required child, and one that seems to have been stopped from outside, are judged half a
    second later. If the manager is asked to stop by then, nothing follows.
    """

    def __init__(self, journal: Journal) -> None:
        self.journal = journal
        self._later: list[tuple[int, Life, float]] = []
        # When whom to start again.
        self._starts: dict[ChildProcess, int] = {}
        self._on_required_end: Callable[[], object] | None = None
        self._status: int | None = None

    @property
    def status(self) -> int:
        """Exit status of the program: the first required child that ends decides it."""
        return self._status or 0

    @property
    def due_ns(self) -> int | None:
        """Time of the next decision, on the monotonic clock."""
        return min([*(due for due, *_ in self._later), *self._starts.values()], default=None)

    def have_called(self, on_required_end: Callable[[], object]) -> None:
        """Call a function when a required child ends for good; at once if one has ended."""
        self._on_required_end = on_required_end
        if self._status is not None:
            on_required_end()

    def ended(self, life: Life, now_ns: int) -> None:
        """Note that a child has ended."""
        ran_s = (now_ns - life.started_ns) / _NS_PER_S
        if not life.may_be_a_stop or not life.has_failed:
            self.journal.write_end(life)
        if self.hesitates(life) and not self.journal.is_ending:
            self._later.append((now_ns + _HESITATION_NS, life, ran_s))
        else:
            self._judge(life, now_ns, ran_s)

    def hesitates(self, life: Life) -> bool:
        """Return whether to wait for half a second, in which the manager may be stopped too."""
        return life.may_be_a_stop or life.child.is_required

    def could_not_start(self, child: ChildProcess, now_ns: int) -> None:
        """Note that a child could not be started again."""
        self.decide(child, now_ns, failed=True, ran_s=0.0, status=1)

    def to_start(self, now_ns: int) -> Iterator[ChildProcess]:
        """Judge children whose time has come; return the ones to start now."""
        waiting, self._later = self._later, []
        for due_ns, life, ran_s in waiting:
            if due_ns <= now_ns or self.journal.is_ending:
                self._judge(life, now_ns, ran_s)
            else:
                self._later.append((due_ns, life, ran_s))
        for child in [child for child, due_ns in self._starts.items() if due_ns <= now_ns]:
            del self._starts[child]
            if not self.journal.is_ending:
                yield child

    def close(self) -> None:
        """Stop judging; write pending ends to the log."""
        for _, life, _ in self._later:
            self.journal.write_end(life)
        self._later.clear()
        self._starts.clear()

    def _judge(self, life: Life, now_ns: int, ran_s: float) -> None:
        self.journal.write_end(life)
        if not self.journal.is_ending:
            status = _status_of(life)
            self.decide(life.child, now_ns, failed=life.has_failed, ran_s=ran_s, status=status)

    def decide(
        self, child: ChildProcess, now_ns: int, *, failed: bool, ran_s: float, status: int
    ) -> None:
        """Decide what follows an end.

        Args:
            child: The child.
            now_ns: Present time, on the monotonic clock.
            failed: Whether it ended with a failure.
            ran_s: Seconds that it ran.
            status: Exit status, as a shell would give it.
        """
        delay_s = child.restarts.after_end(failed=failed, ran_s=ran_s)
        if delay_s is not None:
            self._starts[child] = now_ns + int(delay_s * _NS_PER_S)
            self.journal.write_restart(child, delay_s)
            return
        self.journal.write_last_end(child)
        if child.is_required and self._status is None:
            self._status = status
            if self._on_required_end is not None:
                self._on_required_end()


def _status_of(life: Life) -> int:
    """Return the exit status of a run, as a shell would give it."""
    code = life.child.exit_code or 0
    return code if code > 0 else 128 - code if code else int(life.has_failed)
