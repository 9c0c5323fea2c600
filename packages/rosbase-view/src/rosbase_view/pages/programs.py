"""Processes and the programs in them."""

from collections.abc import Hashable, Sequence

from rosbase.control.shapes import Process, Program
from rosbase_view.drawing.figures import duration, rate, size
from rosbase_view.drawing.lines import Ink, Line, Span, clipped, line
from rosbase_view.drawing.table import Cell, Column
from rosbase_view.pages.base import BasePage
from rosbase_view.pages.page import Pane

__all__ = ["ProgramsPage", "state_of"]


class ProgramsPage(BasePage):
    """All programs, with what their processes take of the machine."""

    title = "programs"
    columns = (
        Column("PROGRAM", 16, share=1),
        Column("STATE", 16, share=1),
        Column("RATE", 9, is_right=True),
        Column("CPU", 6, is_right=True),
        Column("MEMORY", 9, is_right=True),
        Column("UP", 9, is_right=True),
        Column("PID", 8, is_right=True),
        Column("OVERRUNS", 8, is_right=True),
        Column("BACKEND", 8),
    )

    def keys(self) -> Sequence[tuple[int, str]]:
        """Return the programs by pid and name."""
        return [(p["pid"], one["name"]) for p in self.known.processes for one in p["programs"]]

    def cells(self, key: Hashable, pane: Pane) -> Sequence[Cell]:
        """Return the cells of a row."""
        process, program = self._find(key)
        cpu = self.known.cpu.get(process["pid"])
        is_silent = process["pid"] in self.known.silent
        is_well = program["phase"] == "running" and not is_silent
        return (
            Cell(program["name"].lstrip("/")),
            Cell(
                "does not answer" if is_silent else state_of(program),
                Ink.GOOD if is_well else Ink.WARNING,
            ),
            Cell("-" if program["rate_hz"] is None else rate(program["rate_hz"])),
            Cell("-" if cpu is None else f"{cpu * 100:.1f} %"),
            Cell(size(process["memory_bytes"])),
            Cell(duration(program["up_ns"])),
            Cell(str(process["pid"]), Ink.DIM),
            Cell(str(program["overruns"])),
            Cell(program["backend"] or "-", Ink.DIM),
        )

    def detail(self, key: Hashable | None, pane: Pane, first: int) -> list[Line]:
        """Return how the process was started, its versions, and its child processes."""
        if key is None:
            return []
        process, program = self._find(key)
        children = [
            f"child {child['name']} [{child['pid']}]{'' if child['running'] else ', ended'}"
            for child in program["children"]
        ]
        texts = (
            " ".join(process["command"]),
            f"Python {process['python']}, rosbase {process['rosbase']},"
            f" {process['threads']} threads",
            *children,
        )
        title = line(Span(clipped(program["name"].lstrip("/"), pane.width), Ink.TITLE))
        return [title, *(line(clipped(text, pane.width)) for text in texts[first:])]

    def _find(self, key: Hashable) -> tuple[Process, Program]:
        return next(
            (process, program)
            for process in self.known.processes
            for program in process["programs"]
            if (process["pid"], program["name"]) == key
        )


def state_of(program: Program) -> str:
    """Return how far a program is: its own state while it runs."""
    if program["phase"] == "handshake" and program["waiting_for"]:
        return f"waiting for {', '.join(program['waiting_for'])}"
    state, phase = program["state"], program["phase"]
    return f"{phase}: {state}" if phase == "running" and state not in (None, "") else phase
