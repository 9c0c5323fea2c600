"""The panes of the view, and its keys."""

from collections.abc import Callable

from textual import events
from textual.app import ComposeResult
from textual.containers import Container
from textual.screen import Screen

from rosbase_view.drawing.lines import Line
from rosbase_view.pages.page import SCROLL_STEP, Edit
from rosbase_view.source import Change, Playback
from rosbase_view.terminal.lines_pane import LinesPane
from rosbase_view.terminal.value_editor import ValueEditor
from rosbase_view.view import PaneSize, View

__all__ = ["MainScreen"]

# From this width on, the details are beside the list.
_WIDE = 120
_BREAKPOINTS = [(0, "-narrow"), (_WIDE, "-wide")]
_FAR = 1_000_000
_ROWS = {"up": -1, "down": 1, "home": -_FAR, "end": _FAR}
_PANES = {"pageup": -1, "pagedown": 1}
_SCROLLS = {"left": -SCROLL_STEP, "right": SCROLL_STEP}
_TURNS = {"tab": 1, "shift+tab": -1}


class MainScreen(Screen[None]):
    """Heading, list, details and status."""

    DEFAULT_CSS = """
    #heading, #status, #time { height: 1; }
    #panes { layout: vertical; height: 1fr; }
    #list, #detail { height: 1fr; width: 1fr; }
    MainScreen.-wide #panes { layout: horizontal; }
    MainScreen.-wide #list { width: 3fr; }
    MainScreen.-wide #detail { width: 2fr; }
    """
    HORIZONTAL_BREAKPOINTS = _BREAKPOINTS

    def __init__(
        self,
        view: View,
        now_ns: Callable[[], int],
        on_change: Callable[[Change], object],
        playback: Playback | None,
    ) -> None:
        """Show a view.

        Args:
            view: What is shown.
            now_ns: Returns the monotonic time.
            on_change: Takes the changes that the user asks for.
            playback: Moves a recording; None if programs are shown.
        """
        super().__init__()
        self._view = view
        self._now_ns = now_ns
        self._on_change = on_change
        self._playback = playback
        self._list_height: int | str = "1fr"

    def compose(self) -> ComposeResult:
        """Return the panes."""
        yield LinesPane(lambda width, _: self._view.draw_heading(width), id="heading")
        with Container(id="panes"):
            yield LinesPane(self._draw_list, id="list")
            yield LinesPane(self._draw_detail, id="detail")
        if self._playback is not None:
            yield LinesPane(lambda width, _: self._view.draw_time(width), id="time")
        yield LinesPane(lambda width, _: self._view.draw_status(width, self._now_ns()), id="status")

    def redraw(self) -> None:
        """Show what is known now."""
        self._share_room()
        for pane in self.query(LinesPane):
            pane.redraw()

    def on_key(self, event: events.Key) -> None:
        """Move, or pass a key to the page.

        These are no bindings of textual, which runs them after the keys that come behind them: the
        key of a transition would then meet the wrong node.
        """
        if self._move(event.key) or self._play(event.key):
            event.stop()
            return
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
            self._view.scroll_detail(message.rows)
        else:
            self._view.move(message.rows)
        self.redraw()

    def _move(self, key: str) -> bool:
        """Choose another row or page, or scroll; return False for another key."""
        view = self._view
        if key in _ROWS:
            view.move(_ROWS[key])
        elif key in _PANES:
            view.move(_PANES[key] * max(1, self.query_one("#list").size.height - 2))
        elif key in _SCROLLS:
            view.scroll_detail(_SCROLLS[key])
        elif key in _TURNS:
            view.turn_to(view.number + _TURNS[key])
        elif key.isdecimal() and 0 < int(key) <= len(view.pages):
            view.turn_to(int(key) - 1)
        else:
            return False
        self.redraw()
        return True

    def _play(self, key: str) -> bool:
        """Move the recording; return False for another key."""
        return self._playback is not None and self._view.press_playback(key, self._playback)

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
