"""The table of a state machine, checked, and indexed for each step."""

from collections.abc import Iterable

from rosbase.fsm.transition import ANY, Transition

__all__ = ["Table"]


class Table:
    """Transitions by the state that they leave, in the order in which they were written."""

    def __init__(self, initial: str, transitions: Iterable[Transition]) -> None:
        """Index the rows, and refuse those that can only be a mistake.

        Raises:
            ValueError: No row names the initial state, or a row can never be taken, because one
                above it always is.
        """
        self.initial = initial
        self.transitions = tuple(transitions)
        named = [name for row in self.transitions for name in (*row.sources, row.target)]
        self.states = tuple(dict.fromkeys(name for name in [initial, *named] if name != ANY))
        self.events = frozenset(row.event for row in self.transitions if row.event is not None)
        if initial == ANY or initial not in named:
            raise ValueError(f"the initial state {initial!r} is not in the table")
        self._rows: dict[tuple[str, str | None], list[Transition]] = {}
        for row in self.transitions:
            self._add(row)

    def leaving(self, state: str, event: str | None) -> list[Transition]:
        """Return the transitions of a state for an event or, without an event, its polled ones."""
        return self._rows.get((state, event), [])

    def edges(self) -> list[tuple[str, Transition]]:
        """Yield each transition with each state that it leaves; `ANY` is written out."""
        return [(source, row) for row in self.transitions for source in self._sources(row)]

    def unreachable(self) -> list[str]:
        """Return the states that no path reaches from the initial one."""
        reached = {self.initial}
        edges = self.edges()
        # Each round goes one edge further, and no way has more edges than there are states.
        for _ in self.states:
            reached |= {row.target for source, row in edges if source in reached}
        return [state for state in self.states if state not in reached]

    def _sources(self, row: Transition) -> list[str]:
        if row.source == ANY:
            return [state for state in self.states if state != row.target]
        return list(row.sources)

    def _add(self, row: Transition) -> None:
        sources = self._sources(row)
        if not sources:
            raise ValueError(f"the transition from any state to {row.target!r} leaves none")
        hidden = [s for s in sources if any(r.when is None for r in self.leaving(s, row.event))]
        # A row for any state may come after one that serves some of them.
        if hidden and (row.source != ANY or hidden == sources):
            on = f"on {row.event!r}" if row.event else "polled"
            raise ValueError(
                f"the transition from {hidden[0]!r} to {row.target!r} ({on}) can never be taken:"
                " one above it has no guard"
            )
        for source in sources:
            self._rows.setdefault((source, row.event), []).append(row)
