"""Decide which program starts, stops or starts again, and when.

This module starts nothing and reads no clock: `Hands` do the first, and events bring the time.
"""

import logging
from collections.abc import Collection, Iterator, Sequence
from typing import Literal, Protocol, TypeAlias

from attrs import define, field

from rosbase.launcher.description import Condition, Program
from rosbase.launcher.description.order import in_order
from rosbase.processes.restart import Restarts

__all__ = ["Entry", "Fleet", "Hands", "State"]

# disabled ──restart──┐
#                     v
# waiting ──ready──> running ──end──> ended, failed
#    │                │  ^  └──end, and the policy says so──> restarting ──due──> running
#    │                │  └──restart──────────────┐
#    └──stop──────────┴──stop──> stopping ──end──┴──> stopped
State: TypeAlias = Literal[
    "disabled", "waiting", "running", "restarting", "stopping", "stopped", "ended", "failed"
]

_NS_PER_S = 1_000_000_000
# A program that takes longer to stop does not hold up the ones that do not depend on it.
_GRACE_NS = 500_000_000
_STARTED, _EXIT_0 = Condition("started"), Condition("exit 0")
_ALIVE = ("running", "stopping")
_OVER = ("ended", "failed")
_AT_REST = ("disabled", "stopped", *_OVER)


class Hands(Protocol):
    """Carries out the decisions. Nothing here waits; events tell the fleet of the outcome."""

    def start(self, program: Program) -> None:
        """Start a program; `Fleet.started` or `Fleet.could_not_start` follows."""
        ...

    def stop(self, program: Program) -> None:
        """Ask a program to stop; `Fleet.ended` follows."""
        ...

    def changed(self, entry: "Entry") -> None:
        """Note that the state of a program has changed."""
        ...

    def say(self, key: str, level: int, text: str) -> None:
        """Show a line about a program; level as in the standard library's `logging`."""
        ...


@define(eq=False)
class Entry:
    """A program and its state."""

    program: Program
    restarts: Restarts
    state: State = "disabled"
    since_ns: int = 0
    """Time of the last change of state, on the monotonic clock."""
    status: int | None = None
    """Exit status of the last run, as a shell would give it; None before its end."""
    total_restarts: int = 0
    """Number of starts after the first."""
    place: int = -1
    """Its place among all starts; -1 before the first."""
    met: set[Condition] = field(factory=set)
    """Conditions that any of its runs has met: the others wait for their first start only."""
    detail: str = ""
    """Reason for the state, or the thing it waits for; may be empty."""
    due_ns: int | None = None
    wants_restart: bool = False
    has_begun: bool = False
    """Whether the system has started the present run."""

    @property
    def key(self) -> str:
        """Key of the program."""
        return self.program.key

    @property
    def is_alive(self) -> bool:
        """Whether it runs, or is about to."""
        return self.state in _ALIVE


class Fleet:
    """All programs of a run."""

    def __init__(self, programs: Sequence[Program], enabled: Collection[str], hands: Hands) -> None:
        """Prepare a run; `begin` starts it.

        Args:
            programs: The programs, with keys that differ.
            enabled: Keys of the ones that start.
            hands: Carries out the decisions.
        """
        by_key = {program.key: program for program in programs}
        order = in_order({key: list(program.after) for key, program in by_key.items()})
        self.entries = {key: Entry(by_key[key], Restarts(by_key[key].restart)) for key in order}
        """Every program by its key, in the order in which they start if nothing has to wait."""
        self.is_stopping = False
        """Whether the whole run is ending."""
        self._enabled = set(enabled)
        self._hands = hands
        self._starts = 0
        self._status: int | None = None
        self._look_again_ns: int | None = None

    @property
    def is_over(self) -> bool:
        """Whether nothing runs, and nothing is going to."""
        return all(entry.state in _AT_REST for entry in self.entries.values())

    @property
    def status(self) -> int:
        """Exit status of the run.

        That of the required program that has ended it; 0 if it was asked to stop; otherwise 1 if
        a program has failed.
        """
        if self._status is not None:
            return self._status
        return int(any(entry.state == "failed" for entry in self.entries.values()))

    @property
    def due_ns(self) -> int | None:
        """Time at which `tick` has something to do, on the monotonic clock."""
        dues = [entry.due_ns for entry in self.entries.values()]
        return min((due for due in [*dues, self._look_again_ns] if due is not None), default=None)

    def wanted(self) -> Iterator[tuple[str, Condition]]:
        """Yield the conditions that somebody waits for, with the program that has to meet them."""
        for entry in self.entries.values():
            if entry.state == "waiting":
                for other, condition in self._missing(entry):
                    if self.entries[other].state == "running":
                        yield other, condition

    # Events.

    def begin(self, now_ns: int) -> None:
        """Start what need not wait."""
        for entry in self.entries.values():
            if entry.key in self._enabled:
                self._wait(entry, now_ns)
        self._start_ready(now_ns)

    def started(self, key: str, now_ns: int) -> None:
        """Take the news that the system has started a program."""
        self.entries[key].has_begun = True
        self.met(key, _STARTED, now_ns)

    def met(self, key: str, condition: Condition, now_ns: int) -> None:
        """Take the news that a running program meets a condition."""
        entry = self.entries[key]
        if entry.is_alive and condition not in entry.met:
            entry.met.add(condition)
            self._start_ready(now_ns)

    def could_not_start(self, key: str, why: str, now_ns: int) -> None:
        """Take the news that the system has refused to start a program."""
        self._hands.say(key, logging.ERROR, f"cannot be started: {why}")
        self.ended(key, 1, 0.0, now_ns)

    def ended(
        self, key: str, status: int, ran_s: float, now_ns: int, *, was_told: bool = False
    ) -> None:
        """Take the news that all processes of a program have ended.

        Args:
            key: The program.
            status: Exit status as a shell would give it.
            ran_s: Seconds that it ran.
            now_ns: Present time.
            was_told: Whether a user has stopped it, as with Ctrl-C in its pane.
        """
        entry = self.entries[key]
        entry.status = status
        entry.has_begun = False
        wants_restart, entry.wants_restart = entry.wants_restart, False
        if entry.state == "stopping" or self.is_stopping or was_told:
            self._change(entry, "stopped", now_ns)
            if wants_restart and not self.is_stopping:
                self._start(entry, now_ns)
        else:
            self._judge(entry, status, ran_s, now_ns)
        self._go_on(now_ns)

    def tick(self, now_ns: int) -> None:
        """Do what is due."""
        for entry in self.entries.values():
            if entry.due_ns is None or entry.due_ns > now_ns:
                continue
            entry.due_ns = None
            if entry.state == "restarting":
                self._start(entry, now_ns)
            elif entry.state == "waiting":
                self._fail(entry, f"has waited {entry.program.after_timeout_s:g} s", now_ns)
        self._go_on(now_ns)

    # Wishes.

    def stop_all(self, now_ns: int, status: int = 0) -> None:
        """Stop everything, in the reverse order of the starts; the run ends with that status."""
        if self.is_stopping:
            return
        self.is_stopping, self._status = True, status
        for entry in self.entries.values():
            entry.wants_restart = False
            if entry.state in ("waiting", "restarting"):
                self._change(entry, "stopped", now_ns)
        self._stop_next(now_ns)

    def stop(self, key: str, now_ns: int) -> None:
        """Stop one program; it does not start again by itself, and the others go on."""
        entry = self.entries[key]
        entry.wants_restart = False
        if entry.state == "running":
            self._stop(entry, now_ns)
        elif entry.state in ("waiting", "restarting"):
            self._change(entry, "stopped", now_ns)
            self._go_on(now_ns)

    def restart(self, key: str, now_ns: int) -> None:
        """Stop one program if it runs, and start it, whatever its policy and conditions say."""
        entry = self.entries[key]
        if self.is_stopping:
            return
        entry.restarts = Restarts(entry.program.restart)
        if entry.is_alive:
            entry.wants_restart = True
            if entry.state == "running":
                self._stop(entry, now_ns)
        else:
            self._start(entry, now_ns)
            self._start_ready(now_ns)

    # Decisions.

    def _judge(self, entry: Entry, status: int, ran_s: float, now_ns: int) -> None:
        """Decide what follows an end that nobody has asked for."""
        if status == 0:
            entry.met.add(_EXIT_0)
        delay_s = entry.restarts.after_end(failed=status != 0, ran_s=ran_s)
        if delay_s is not None:
            count = f"{entry.restarts.in_a_row} of {entry.restarts.policy.limit}"
            self._start_ready(now_ns)
            entry.detail = f"in {delay_s:.1f} s ({count})"
            entry.due_ns = now_ns + int(delay_s * _NS_PER_S)
            self._change(entry, "restarting", now_ns)
            return
        if entry.restarts.has_given_up:
            text = f"not started again: {entry.restarts.in_a_row} in a row"
            self._hands.say(entry.key, logging.ERROR, text)
        entry.detail = f"status {status}"
        self._over(entry, "failed" if status else "ended", status, now_ns)

    def _fail(self, entry: Entry, why: str, now_ns: int) -> None:
        """Give up a program that cannot start."""
        missing = ", ".join(f"{key}: {condition}" for key, condition in self._missing(entry))
        entry.detail = f"{why} for {missing}"
        self._hands.say(entry.key, logging.ERROR, f"cannot start: {entry.detail}")
        self._over(entry, "failed", 1, now_ns)

    def _over(self, entry: Entry, state: State, status: int, now_ns: int) -> None:
        self._change(entry, state, now_ns)
        if entry.program.is_required and not self.is_stopping:
            self._hands.say(entry.key, logging.ERROR, "is required, so all others are stopped")
            self.stop_all(now_ns, status)

    def _go_on(self, now_ns: int) -> None:
        if self.is_stopping:
            self._stop_next(now_ns)
        else:
            self._start_ready(now_ns)

    def _start_ready(self, now_ns: int) -> None:
        """Start every program that has waited long enough; fail those that would wait for ever."""
        # The end of one may take the hope of another.
        while any(self._start_or_fail(entry, now_ns) for entry in self.entries.values()):
            pass

    def _start_or_fail(self, entry: Entry, now_ns: int) -> bool:
        """Start a program if nothing is missing; return whether it has failed instead."""
        if entry.state != "waiting" or self.is_stopping:
            return False
        missing = list(self._missing(entry))
        if not missing:
            self._start(entry, now_ns)
            return False
        for key, _ in missing:
            if why := self._hopeless(self.entries[key]):
                self._fail(entry, f"{key} {why}, and it waits", now_ns)
                return True
        detail = "for " + ", ".join(f"{key}: {condition}" for key, condition in missing)
        if detail != entry.detail:
            entry.detail = detail
            self._hands.changed(entry)
        return False

    def _hopeless(self, entry: Entry) -> str:
        """Return why a program will not meet a condition any more; empty if it may."""
        if entry.state in _OVER:
            return "has ended" if entry.place >= 0 else "never started"
        # A user may start it again, as long as the run lasts.
        lasts = any(e.is_alive or e.state == "restarting" for e in self.entries.values())
        return "was stopped" if entry.state == "stopped" and not lasts else ""

    def _missing(self, entry: Entry) -> Iterator[tuple[str, Condition]]:
        for key, condition in entry.program.after.items():
            other = self.entries[key]
            if other.state != "disabled" and condition not in other.met:
                yield key, condition

    def _wait(self, entry: Entry, now_ns: int) -> None:
        for key, condition in entry.program.after.items():
            if key not in self._enabled:
                text = f"does not wait for {key}: {condition}, because {key} is disabled"
                self._hands.say(entry.key, logging.WARNING, text)
        # Silently: most do not wait at all.
        entry.state, entry.since_ns = "waiting", now_ns
        if entry.program.after and entry.program.after_timeout_s is not None:
            entry.due_ns = now_ns + int(entry.program.after_timeout_s * _NS_PER_S)

    def _start(self, entry: Entry, now_ns: int) -> None:
        entry.status = None
        entry.detail = ""
        entry.due_ns = None
        entry.total_restarts += entry.place >= 0
        entry.place, self._starts = self._starts, self._starts + 1
        self._change(entry, "running", now_ns)
        self._hands.start(entry.program)

    def _stop(self, entry: Entry, now_ns: int) -> None:
        self._change(entry, "stopping", now_ns)
        self._hands.stop(entry.program)

    def _stop_next(self, now_ns: int) -> None:
        """Stop the program that was started last, and the ones before it in their turn."""
        self._look_again_ns = None
        alive = [entry for entry in self.entries.values() if entry.is_alive]
        dependents = {key for entry in alive for key in entry.program.after}
        for entry in sorted(alive, key=lambda entry: -entry.place):
            if entry.state == "running" and entry.key not in dependents:
                self._stop(entry, now_ns)
            if entry.state == "stopping" and now_ns - entry.since_ns < _GRACE_NS:
                self._look_again_ns = entry.since_ns + _GRACE_NS
                return

    def _change(self, entry: Entry, state: State, now_ns: int) -> None:
        if state == "stopped":
            entry.detail = ""
            entry.due_ns = None
        entry.state, entry.since_ns = state, now_ns
        self._hands.changed(entry)
