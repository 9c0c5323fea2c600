"""Nodes with their lifecycle, and keys that drive it."""

from collections.abc import Hashable, Sequence

from rosbase_view.drawing.lines import Ink, Line, Span, clipped, line
from rosbase_view.drawing.table import Cell, Column
from rosbase_view.pages.base import BasePage
from rosbase_view.pages.page import Edit, Pane
from rosbase_view.reports import NodeKey
from rosbase_view.source import Change, ChangeState, Gaze

__all__ = ["PARAMETERS", "NodesPage"]

PARAMETERS = 2
"""Number of the page of parameters, from 0 on."""

_TRANSITIONS = {
    "c": "configure",
    "a": "activate",
    "d": "deactivate",
    "u": "cleanup",
    "s": "shutdown",
}
_INKS = {"active": Ink.GOOD, "inactive": Ink.WARNING, "finalized": Ink.BAD}


class NodesPage(BasePage):
    """The nodes of all programs."""

    title = "nodes"
    hints: Sequence[tuple[str, str]] = (("c a d u s", "lifecycle"), ("enter", "parameters"))
    detail_rows = 7
    columns = (
        Column("NODE", 24, share=2),
        Column("LIFECYCLE", 14),
        Column("PROGRAM", 16, share=1),
        Column("PID", 8, is_right=True),
    )

    def keys(self) -> Sequence[NodeKey]:
        """Return the nodes by name."""
        return sorted(self.known.nodes)

    def cells(self, key: Hashable, pane: Pane) -> Sequence[Cell]:
        """Return the cells of a row."""
        node = self.known.nodes[_key(key)]
        state = node.lifecycle or "-"
        return (
            Cell(node.key[0]),
            Cell(state, _INKS.get(state, Ink.DIM if node.lifecycle is None else Ink.PLAIN)),
            Cell(node.program.lstrip("/")),
            Cell(str(node.key[1]), Ink.DIM),
        )

    def detail(self, key: Hashable | None, pane: Pane, first: int) -> list[Line]:
        """Return the transitions that the node offers, with their keys."""
        if key is None:
            return []
        lines = [line(Span(clipped(_key(key)[0], pane.width), Ink.TITLE))]
        offered = self._offered(_key(key))
        if self.known.nodes[_key(key)].lifecycle is None:
            return [*lines, line(Span("has no lifecycle", Ink.DIM))]
        lines += [
            line(f"{letter}  ", transition)
            for letter, transition in _TRANSITIONS.items()
            if transition in offered
        ]
        return lines if len(lines) > 1 else [*lines, line(Span("offers no transition", Ink.DIM))]

    def gaze(self, key: Hashable | None) -> Gaze:
        """Look at the node."""
        return Gaze(nodes=frozenset(() if key is None else (_key(key),)))

    def press(self, key: str, chosen: Hashable | None) -> Change | Edit | int | None:
        """Run a transition that the node offers, or go to its parameters."""
        if chosen is None:
            return None
        if key == "enter":
            return PARAMETERS
        transition = _TRANSITIONS.get(key)
        if transition is None or transition not in self._offered(_key(chosen)):
            return None
        return ChangeState(_key(chosen), transition)

    def _offered(self, key: NodeKey) -> Sequence[str]:
        """Return the transitions that the node offers, as far as it has told."""
        report = self.known.node_reports.get(key)
        return () if report is None else report.transitions


def _key(key: Hashable) -> NodeKey:
    assert isinstance(key, tuple)
    return key
