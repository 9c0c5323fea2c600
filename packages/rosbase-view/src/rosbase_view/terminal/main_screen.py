"""The panes of the view, and its keys."""

from collections.abc import Callable
from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Container
from textual.screen import Screen

from rosbase_view.drawing.lines import Line
from rosbase_view.pages.page import SCROLL_STEP, Edit
from rosbase_view.source import Change
from rosbase_view.terminal.lines_pane import LinesPane
from rosbase_view.terminal.value_editor import ValueEditor
from rosbase_view.view import PaneSize, View

__all__ = ["MainScreen"]

# From this width on, the details are beside the list.
_WIDE = 120
_BREAKPOINTS = [(0, "-narrow"), (_WIDE, "-wide")]
_FAR = 1_000_000


class MainScreen(Screen[None]):
    """Heading, list, details and status."""

    DEFAULT_CSS = """
    #heading, #status { height: 1; }
    #panes { layout: vertical; height: 1fr; }
    #list, #detail { height: 1fr; width: 1fr; }
    MainScreen.-wide #panes { layout: horizontal; }
    MainScreen.-wide #list { width: 3fr; }
    MainScreen.-wide #detail { width: 2fr; }
    """
    HORIZONTAL_BREAKPOINTS = _BREAKPOINTS
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up", "move(-1)", show=False),
        Binding("down", "move(1)", show=False),
        Binding("pageup", "move_page(-1)", show=False),
        Binding("pagedown", "move_page(1)", show=False),
        Binding("home", f"move({-_FAR})", show=False),
        Binding("end", f"move({_FAR})", show=False),
        Binding("left", f"scroll_detail({-SCROLL_STEP})", show=False),
        Binding("right", f"scroll_detail({SCROLL_STEP})", show=False),
        Binding("tab", "turn(1)", show=False),
        Binding("shift+tab", "turn(-1)", show=False),
        *(Binding(str(n + 1), f"turn_to({n})", show=False) for n in range(6)),
    ]

    def __init__(
        self, view: View, now_ns: Callable[[], int], on_change: Callable[[Change], object]
    ) -> None:
        """Show a view.

        Args:
            view: What is shown.
            now_ns: Returns the monotonic time.
            on_change: Takes the changes that the user asks for.
        """
        super().__init__()
        self._view = view
        self._now_ns = now_ns
        self._on_change = on_change
        self._list_height: int | str = "1fr"

    def compose(self) -> ComposeResult:
        """Return the panes."""
        yield LinesPane(lambda width, _: self._view.draw_heading(width), id="heading")
        with Container(id="panes"):
            yield LinesPane(self._draw_list, id="list")
            yield LinesPane(self._draw_detail, id="detail")
        yield LinesPane(lambda width, _: self._view.draw_status(width, self._now_ns()), id="status")

    def redraw(self) -> None:
        """Show what is known now."""
        self._share_room()
        for pane in self.query(LinesPane):
            pane.redraw()

    def on_key(self, event: events.Key) -> None:
        """Pass a key to the page."""
        done = self._view.press(event.key)
        if done is not None:
            # The editor that is about to open must not take the same key.
            event.stop()
        if isinstance(done, Change):
            self._on_change(done)
        elif done is not None:
            self._edit(done)
        self.redraw()

    def on_lines_pane_row_clicked(self, message: LinesPane.RowClicked) -> None:
        """Choose the row, or the page."""
        if message.pane.id == "list":
            self._view.choose_at(message.y)
            self.redraw()

    def on_lines_pane_scrolled(self, message: LinesPane.Scrolled) -> None:
        """Move the cursor, or scroll the details."""
        if message.pane.id == "detail":
            self.action_scroll_detail(message.rows)
        else:
            self.action_move(message.rows)

    def action_move(self, rows: int) -> None:
        """Choose another row."""
        self._view.move(rows)
        self.redraw()

    def action_move_page(self, pages: int) -> None:
        """Choose a row that is a whole pane away."""
        self.action_move(pages * max(1, self.query_one("#list").size.height - 2))

    def action_scroll_detail(self, lines: int) -> None:
        """Scroll the details."""
        self._view.scroll_detail(lines)
        self.redraw()

    def action_turn(self, pages: int) -> None:
        """Show the next page, or the one before."""
        self.action_turn_to(self._view.number + pages)

    def action_turn_to(self, number: int) -> None:
        """Show a page."""
        self._view.turn_to(number)
        self.redraw()

    def _share_room(self) -> None:
        """Give the list the rows that it needs, if the details are below it."""
        room = self.query_one("#panes").size.height
        if self.size.width >= _WIDE or room <= 0:
            height: int | str = "1fr"
        else:
            height = self._view.list_rows(room)
        if height != self._list_height:
            self._list_height = height
            self.query_one("#list").styles.height = height

    def _edit(self, edit: Edit) -> None:
        def done(text: str | None) -> None:
            if text is not None:
                self._on_change(edit.change(text))

        self.app.push_screen(ValueEditor(edit.title, edit.text), done)

    def _draw_list(self, width: int, height: int) -> list[Line]:
        return self._view.draw_list(PaneSize(width, height, self._now_ns()))

    def _draw_detail(self, width: int, height: int) -> list[Line]:
        size = PaneSize(width, height, self._now_ns())
        return self._view.draw_detail(size, is_beside=self.size.width >= _WIDE)
