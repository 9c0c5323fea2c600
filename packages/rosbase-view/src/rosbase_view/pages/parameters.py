"""Parameters of a node, to read and to edit."""

import json
from collections.abc import Callable, Hashable, Sequence
from textwrap import wrap

from attrs import frozen

from rosbase_view.drawing.glyphs import Glyphs
from rosbase_view.drawing.lines import Ink, Line, Span, clipped, line
from rosbase_view.drawing.table import Cell, Column
from rosbase_view.known import Known
from rosbase_view.pages.base import BasePage
from rosbase_view.pages.page import Edit, Pane
from rosbase_view.reports import NodeKey, ParameterRow
from rosbase_view.source import Change, Gaze, SetParameter

__all__ = ["ParameterEdit", "ParametersPage"]


@frozen
class ParameterEdit:
    """A parameter that the user edits."""

    node: NodeKey
    name: str
    kind: str
    text: str

    @property
    def title(self) -> str:
        """Name of the parameter, with its type."""
        return f"{self.name} ({self.kind})"

    def change(self, text: str) -> Change:
        """Return the change to the new value."""
        return SetParameter(self.node, self.name, text)


class ParametersPage(BasePage):
    """The parameters of the node that was chosen on the page of nodes."""

    title = "parameters"
    hints: Sequence[tuple[str, str]] = (("enter", "edit"),)
    columns = (Column("PARAMETER", 24, share=1), Column("VALUE", 20, share=2), Column("TYPE", 20))

    def __init__(
        self, known: Known, glyphs: Glyphs, chosen_node: Callable[[], NodeKey | None]
    ) -> None:
        """Show the parameters of the node that `chosen_node` returns."""
        super().__init__(known, glyphs)
        self._chosen_node = chosen_node

    def keys(self) -> Sequence[str]:
        """Return the names."""
        return [row.name for row in self._rows()]

    def cells(self, key: Hashable, pane: Pane) -> Sequence[Cell]:
        """Return the cells of a row."""
        row = self._row(key)
        if row is None:
            return [Cell("")] * len(self.columns)
        kind = f"{row.kind}, fixed" if row.is_read_only else row.kind
        return Cell(row.name), Cell(_text(row.value)), Cell(kind, Ink.DIM)

    def detail(self, key: Hashable | None, pane: Pane, first: int) -> list[Line]:
        """Return the meaning of the parameter."""
        node = self._chosen_node()
        if node is None and self.known.position is not None:
            return []
        if node is None:
            return [line(Span("choose a node on page 2", Ink.DIM))]
        lines = [line(Span(clipped(f"parameters of {node[0]}", pane.width), Ink.TITLE))]
        row = self._row(key)
        if row is None:
            return [*lines, line(Span("none yet", Ink.DIM))]
        for text in (row.description, row.constraints):
            lines += [line(clipped(part, pane.width)) for part in wrap(text, max(1, pane.width))]
        return lines[: pane.height]

    def gaze(self, key: Hashable | None) -> Gaze:
        """Look at the node."""
        node = self._chosen_node()
        return Gaze(nodes=frozenset(() if node is None else (node,)))

    def press(self, key: str, chosen: Hashable | None) -> Change | Edit | int | None:
        """Edit the chosen parameter, unless it is fixed."""
        row, node = self._row(chosen), self._chosen_node()
        if key != "enter" or row is None or node is None or row.is_read_only:
            return None
        return ParameterEdit(node, row.name, row.kind, _text(row.value))

    def _rows(self) -> Sequence[ParameterRow]:
        node = self._chosen_node()
        report = None if node is None else self.known.node_reports.get(node)
        return () if report is None else report.parameters

    def _row(self, key: Hashable | None) -> ParameterRow | None:
        return next((row for row in self._rows() if row.name == key), None)


def _text(value: object) -> str:
    """Return a value as a user would write it."""
    return value if isinstance(value, str) else json.dumps(value)
