"""The machine: holds the current state and takes the transitions."""

from collections.abc import Callable, Iterable, Mapping
from typing import Protocol

from rosbase.fsm.mermaid import draw
from rosbase.fsm.table import Table
from rosbase.fsm.transition import Action, Transition

__all__ = ["Machine", "StateHolder"]


class StateHolder(Protocol):
    """An object that holds the state in an attribute. Handlers hold the manager's."""

    # A property, because pyright refuses one in an object where the protocol has an attribute.
    @property
    def state(self) -> str | None:
        """Current state; None before the first."""
        ...

    @state.setter
    def state(self, value: str | None) -> None: ...


class Machine:
    """Takes transitions of a table, one at a time. Use it from one thread; it reads no time.

    A transition is, in this order: `on_exit` of its source, the change of the state, its
    `then`, `on_enter` of its target, `on_transition`. If one of them raises, `step` or `send`
    raises the exception, and the calls after it are left out. If `on_exit` raised, the machine
    is still in the source, and the same transition may be taken again. If a later one raised,
    it is in the target.

    With a holder others may set the state too. The machine follows at its next step or
    event, before anything else: `on_exit` of the state it knew, `on_enter` of the new one.
    No transition of the table was taken then, so `on_transition` is not called.
    """

    def __init__(
        self,
        initial: str,
        transitions: Iterable[Transition],
        *,
        on_enter: Mapping[str, Action] | None = None,
        on_exit: Mapping[str, Action] | None = None,
        during: Mapping[str, Action] | None = None,
        on_transition: Callable[[Transition], object] | None = None,
        holder: StateHolder | None = None,
    ) -> None:
        """Check the table and call nothing; the first step enters the initial state.

        Args:
            initial: The state to begin in, unless the holder has one already.
            transitions: The table. If several could be taken, the first one is.
            on_enter: By state, called when it is entered.
            on_exit: By state, called when it is left.
            during: By state, called at the end of each step in it, the one that entered it
                included.
            on_transition: Called with each transition after it was taken.
            holder: Holds the state; by default the machine itself does.

        Raises:
            ValueError: The initial state or a state with an action is not in the table, or a row
                can never be taken. Without a holder, also if no path leads to a state.
        """
        self._table = Table(initial, transitions)
        self._on_enter = self._checked("on_enter", on_enter)
        self._on_exit = self._checked("on_exit", on_exit)
        self._during = self._checked("during", during)
        self._on_transition = on_transition
        self._holder = holder
        self._state: str | None = None
        self._previous: str | None = None
        self._steps_in_state = 0
        self._busy = False
        unreachable = self._table.unreachable()
        if holder is None and unreachable:
            raise ValueError(f"no transitions lead from {initial!r} to {', '.join(unreachable)}")

    def __repr__(self) -> str:
        return (
            f"<Machine state={self.state!r} previous={self.previous!r}"
            f" steps_in_state={self.steps_in_state} states={list(self.states)}>"
        )

    @property
    def state(self) -> str:
        """State of the machine; before the first step, the initial one.

        States set in the holder by others are seen here once the machine has followed.
        """
        held = self._holder.state if self._holder is not None else None
        return self._state or held or self._table.initial

    @property
    def previous(self) -> str | None:
        """Previous state; None as long as there was none."""
        return self._previous

    @property
    def states(self) -> tuple[str, ...]:
        """All states: the initial one, then in the order of the table."""
        return self._table.states

    @property
    def steps_in_state(self) -> int:
        """Number of steps begun since the state was entered.

        It is 0 in the step that enters a state, and n in the n-th step after that. At 10
        steps a second, `steps_in_state >= 20` holds two seconds after the state was
        entered.
        """
        return self._steps_in_state

    def step(self) -> Transition | None:
        """Take the first polled transition whose guard holds, if any; then run `during`.

        Returns:
            The transition that was taken.

        Raises:
            RuntimeError: Called by a guard or an action of this machine.
            ValueError: The holder was given a state that is not in the table.
        """
        self._begin("step")
        try:
            self._steps_in_state += 1
            taken = self._take_first(self._arrive(), None)
            during = self._during.get(self.state)
            if during is not None:
                during()
            return taken
        finally:
            self._busy = False

    def send(self, event: str) -> Transition | None:
        """Take the first transition for that event whose guard holds, if any.

        Does not call `during`.

        Returns:
            The transition that was taken; None where the current state has none.

        Raises:
            RuntimeError: Called by a guard or an action of this machine.
            ValueError: No row at all has that event, or the holder was given a state that is
                not in the table.
        """
        if event not in self._table.events:
            raise ValueError(f"no transition has the event {event!r}")
        self._begin("send")
        try:
            return self._take_first(self._arrive(), event)
        finally:
            self._busy = False

    def to_mermaid(self) -> str:
        """Return the table as the text of a Mermaid state diagram. Each line has a line end."""
        return draw(self._table)

    def _checked(self, what: str, actions: Mapping[str, Action] | None) -> dict[str, Action]:
        for state in actions or {}:
            if state not in self._table.states:
                raise ValueError(f"{what} has the state {state!r}, which is not in the table")
        return dict(actions or {})

    def _begin(self, what: str) -> None:
        if self._busy:
            raise RuntimeError(f"{what}() was called from within a step of the same machine")
        self._busy = True

    def _arrive(self) -> str:
        """Enter the first state, or follow the holder; return the current state."""
        wanted = self._wanted()
        if wanted is None or wanted not in self._table.states:
            raise ValueError(f"the state was set to {wanted!r}, which is not in the table")
        if wanted != self._state:
            self._leave(self._state)
            self._change(wanted)
            self._enter(wanted)
        return wanted

    def _wanted(self) -> str | None:
        held = self._holder.state if self._holder is not None else self._state
        if held is None and self._state is None:
            return self._table.initial
        return held

    def _take_first(self, state: str, event: str | None) -> Transition | None:
        for row in self._table.leaving(state, event):
            if row.when is None or row.when():
                self._take(row)
                return row
        return None

    def _take(self, row: Transition) -> None:
        self._leave(self._state)
        self._change(row.target)
        if row.then is not None:
            row.then()
        self._enter(row.target)
        if self._on_transition is not None:
            self._on_transition(row)

    def _leave(self, state: str | None) -> None:
        action = self._on_exit.get(state) if state is not None else None
        if action is not None:
            action()

    def _change(self, state: str) -> None:
        self._previous, self._state = self._state, state
        self._steps_in_state = 0
        if self._holder is not None:
            self._holder.state = state

    def _enter(self, state: str) -> None:
        action = self._on_enter.get(state)
        if action is not None:
            action()
