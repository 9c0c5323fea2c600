"""A widget that shows lines of the model, and redraws only those that have changed."""

from collections.abc import Callable

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.geometry import Region
from textual.message import Message
from textual.strip import Strip
from textual.widget import Widget

from rosbase_view.drawing.lines import Ink, Line, fitted

__all__ = ["LinesPane"]

_STYLES = {
    Ink.PLAIN: Style(),
    Ink.DIM: Style(dim=True),
    Ink.TITLE: Style(bold=True),
    Ink.GOOD: Style(color="green"),
    Ink.WARNING: Style(color="yellow", bold=True),
    Ink.BAD: Style(color="red", bold=True),
    Ink.CHOSEN: Style(reverse=True),
    Ink.DRAWING: Style(color="cyan"),
    # The axes have the colours that rviz gives them.
    Ink.X: Style(color="red"),
    Ink.Y: Style(color="green"),
    Ink.Z: Style(color="blue"),
}


class LinesPane(Widget):
    """Lines as wide as the widget."""

    ALLOW_SELECT = False

    class RowClicked(Message):
        """A line was clicked."""

        def __init__(self, pane: "LinesPane", y: int) -> None:
            """Say which pane, and which of its lines."""
            super().__init__()
            self.pane = pane
            self.y = y

    class Scrolled(Message):
        """The wheel of the mouse was turned."""

        def __init__(self, pane: "LinesPane", rows: int) -> None:
            """Say which pane, and how far down."""
            super().__init__()
            self.pane = pane
            self.rows = rows

    def __init__(
        self,
        draw: Callable[[int, int], list[Line]],
        *,
        id: str,  # noqa: A002 - textual's name
    ) -> None:
        """Show what `draw` returns for a width and a height."""
        super().__init__(id=id)
        self._draw = draw
        self._lines: list[Line] = []
        self._strips: list[Strip | None] = []
        self._drawn_width = 0

    def redraw(self) -> int:
        """Draw again, and have the terminal show the lines that have changed; return how many."""
        width, height = self.size.width, self.size.height
        if width != self._drawn_width or height != len(self._lines):
            self._forget(width)
        new = self._draw(width, height)[:height]
        new += [()] * (height - len(new))
        # Most lines are the same objects as before, which costs nothing to find out.
        changed = [
            y for y, line in enumerate(new) if y >= len(self._lines) or line != self._lines[y]
        ]
        self._strips += [None] * (height - len(self._strips))
        for y in changed:
            self._strips[y] = None
        self._lines = new
        if changed:
            self.refresh(*(Region(0, y, width, 1) for y in changed))
        return len(changed)

    def render_line(self, y: int) -> Strip:
        """Return a line for the terminal; textual calls it."""
        if y >= len(self._lines):
            return Strip.blank(self.size.width, self.rich_style)
        strip = self._strips[y]
        if strip is None:
            strip = self._strips[y] = self._strip(self._lines[y])
        return strip

    def notify_style_update(self) -> None:
        """Forget what was drawn in other colours; textual calls it."""
        super().notify_style_update()
        self._strips = [None] * len(self._lines)

    def on_resize(self) -> None:
        """Draw for the new size."""
        self.redraw()

    def on_click(self, event: events.Click) -> None:
        """Tell the screen which line it was."""
        self.post_message(self.RowClicked(self, event.y))

    def on_mouse_scroll_down(self) -> None:
        """Tell the screen."""
        self.post_message(self.Scrolled(self, 1))

    def on_mouse_scroll_up(self) -> None:
        """Tell the screen."""
        self.post_message(self.Scrolled(self, -1))

    def _forget(self, width: int) -> None:
        self._drawn_width = width
        self._lines, self._strips = [], []

    def _strip(self, line: Line) -> Strip:
        base, width = self.rich_style, self.size.width
        segments = [Segment(span.text, base + _STYLES[span.ink]) for span in fitted(line, width)]
        return Strip(segments, width)
