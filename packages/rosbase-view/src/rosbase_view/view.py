"""The page, the chosen row, the lines of each pane, and the keys. Pure."""

from collections.abc import Hashable, Sequence

from attrs import frozen

from rosbase_view.drawing.figures import counted
from rosbase_view.drawing.glyphs import Glyphs
from rosbase_view.drawing.lines import Ink, Line, Span, blank, cells, clipped, joined, line, plain
from rosbase_view.known import Known
from rosbase_view.pages.log import LogPage
from rosbase_view.pages.loop import LoopPage
from rosbase_view.pages.nodes import NodesPage
from rosbase_view.pages.page import Edit, Page
from rosbase_view.pages.parameters import ParametersPage
from rosbase_view.pages.programs import ProgramsPage
from rosbase_view.pages.topics import TopicsPage
from rosbase_view.reports import NodeKey
from rosbase_view.source import Change, Gaze, Playback
from rosbase_view.timeline import HINTS, draw_timeline
from rosbase_view.timeline import press as press_timeline

__all__ = ["PaneSize", "View"]

_NODES = 1
_KEYS = (("q", "quit"), ("1-6", "page"), ("up down", "row"))


@frozen
class PaneSize:
    """Size of a pane, and the time."""

    width: int
    height: int
    now_ns: int


class View:
    """The view of everything that is known."""

    def __init__(self, known: Known, glyphs: Glyphs) -> None:
        """Begin on the page of topics."""
        self.known = known
        self.glyphs = glyphs
        self.pages: Sequence[Page] = (
            TopicsPage(known, glyphs),
            NodesPage(known, glyphs),
            ParametersPage(known, glyphs, self.chosen_node),
            LogPage(known, glyphs),
            LoopPage(known, glyphs),
            ProgramsPage(known, glyphs),
        )
        self.number = 0
        """Number of the page, from 0 on."""
        self._cursors = [_Cursor(page) for page in self.pages]
        self._detail_first = 0

    @property
    def page(self) -> Page:
        """Page that is shown."""
        return self.pages[self.number]

    @property
    def chosen(self) -> Hashable | None:
        """Row that is chosen; None if there are no rows."""
        return self._cursors[self.number].key()

    @property
    def gaze(self) -> Gaze:
        """Topics and nodes that the user looks at."""
        return self.page.gaze(self.chosen)

    def chosen_node(self) -> NodeKey | None:
        """Return the node that is chosen on the page of nodes."""
        key = self._cursors[_NODES].key()
        return key if isinstance(key, tuple) else None

    def turn_to(self, number: int) -> None:
        """Show a page; after the last one comes the first."""
        self.number = number % len(self.pages)
        self._detail_first = 0

    def move(self, rows: int) -> None:
        """Choose a row further down, or further up for a negative number."""
        self._cursors[self.number].move(rows)
        self._detail_first = 0

    def choose_at(self, y: int) -> None:
        """Choose the row that is drawn at a line of the list."""
        self._cursors[self.number].choose_shown(y - 1)
        self._detail_first = 0

    def scroll_detail(self, lines: int) -> None:
        """Show what is further down in the details."""
        self._detail_first = max(0, self._detail_first + lines)

    def press(self, key: str) -> Change | Edit | None:
        """Take a key for the page; return a change or a value to edit."""
        done = self.page.press(key, self.chosen)
        if isinstance(done, int):
            self.turn_to(done)
            return None
        return done

    def list_rows(self, room: int) -> int:
        """Return how many rows the list should have, if the details are below it.

        What the list does not need is for the details, and a long list leaves them enough.
        """
        needed = len(self.page.keys()) + 1
        return max(min(needed, room - self.page.detail_rows), min(needed, room // 3), 2)

    def press_playback(self, key: str, playback: Playback) -> bool:
        """Take a key for the recording; return whether it was one."""
        position = self.known.position
        if position is None:
            return False
        moved = press_timeline(key, position, playback)
        if moved is not None:
            # The next key may come before the source reports it.
            self.known.move(moved, is_jump=moved.now_ns != position.now_ns)
        return moved is not None

    def draw_heading(self, width: int) -> list[Line]:
        """Return the line with the names of the pages; the page shown is in brackets."""
        parts: list[Span | str] = []
        for number, page in enumerate(self.pages):
            name = f"{number + 1} {page.title}"
            shown = number == self.number
            parts.append(
                Span(f"[{name}]" if shown else f" {name} ", Ink.TITLE if shown else Ink.DIM)
            )
        names = line(*parts)
        known = self.known
        found = counted(len(known.processes), "program") if known.position is None else "recording"
        found += " "
        gap = width - cells(plain(names)) - len(found)
        return [joined((names, blank(gap), line(Span(found, Ink.DIM)))) if gap > 0 else names]

    def draw_list(self, size: PaneSize) -> list[Line]:
        """Return the titles and the rows of the page."""
        page, cursor = self.page, self._cursors[self.number]
        shown = cursor.shown(max(0, size.height - 1))
        chosen = cursor.key()
        rows = [page.row(key, size, is_chosen=key == chosen) for key in shown]
        if not rows:
            rows = [line(Span(f"  {self._why_empty()}", Ink.DIM))]
        return [page.head(size.width), *rows]

    def draw_detail(self, size: PaneSize, *, is_beside: bool) -> list[Line]:
        """Return the details of the chosen row, apart from the list by a bar or a rule."""
        bar = f"{self.glyphs.bar} " if is_beside else ""
        rule = [] if is_beside else [line(Span(self.glyphs.rule * size.width, Ink.DIM))]
        room = PaneSize(size.width - len(bar), size.height - len(rule), size.now_ns)
        lines = self.page.detail(self.chosen, room, self._detail_first)
        if not is_beside:
            return [*rule, *lines]
        lines += [()] * (size.height - len(lines))
        return [joined((line(Span(bar, Ink.DIM)), one)) for one in lines]

    def draw_time(self, width: int) -> list[Line]:
        """Return the line of a recording; none of what runs."""
        position = self.known.position
        return [] if position is None else [draw_timeline(position, width, self.glyphs)]

    def draw_status(self, width: int, now_ns: int) -> list[Line]:
        """Return what the user should read now, or the keys."""
        said = self.known.said(now_ns)
        if said is not None:
            ink = Ink.BAD if said.is_error else Ink.GOOD
            return [line(Span(clipped(said.text, width), ink))]
        parts: list[Span | str] = []
        playback = () if self.known.position is None else HINTS
        # Without a row there is nothing that these keys could do.
        own = self.page.hints if self.page.keys() else ()
        for key, action in (*_KEYS, *own, *playback):
            parts += [Span(f" {key} ", Ink.TITLE), f"{action} "]
        return [line(*parts)]

    def _why_empty(self) -> str:
        if not self.known.has_survey:
            return "looking for programs"
        if self.known.position is not None:
            if self.page.title == LogPage.title:
                return "no record of /rosout yet"
            return f"{self.page.title}: not shown for a recording"
        return f"no {self.page.title}" if self.known.processes else "no program runs"


class _Cursor:
    """The chosen row of a page. It stays with its row when others come and go."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._key: Hashable | None = None
        self._index = 0
        self._first = 0
        self._is_at_end = page.follows

    def key(self) -> Hashable | None:
        """Return the chosen row."""
        keys = self._page.keys()
        if not keys:
            return None
        self._find(keys)
        return keys[self._index]

    def move(self, rows: int) -> None:
        keys = self._page.keys()
        if keys:
            self._find(keys)
            self._choose(keys, self._index + rows)

    def choose_shown(self, row: int) -> None:
        keys = self._page.keys()
        if row >= 0 and self._first + row < len(keys):
            self._choose(keys, self._first + row)

    def shown(self, height: int) -> Sequence[Hashable]:
        """Return as many rows as fit, with the chosen one among them."""
        keys = self._page.keys()
        if not keys or height <= 0:
            return ()
        self._find(keys)
        self._first = min(self._first, self._index, max(0, len(keys) - height))
        self._first = max(self._first, self._index - height + 1)
        return keys[self._first : self._first + height]

    def _choose(self, keys: Sequence[Hashable], index: int) -> None:
        self._index = max(0, min(index, len(keys) - 1))
        self._key = keys[self._index]
        self._is_at_end = self._page.follows and self._index == len(keys) - 1

    def _find(self, keys: Sequence[Hashable]) -> None:
        """Find the chosen row again; the one in its place if it is gone."""
        if self._is_at_end:
            self._choose(keys, len(keys) - 1)
        elif self._key is None and (first := self._page.first_choice()) is not None:
            self._choose(keys, keys.index(first))
        elif not (self._index < len(keys) and keys[self._index] == self._key):
            known = self._key is not None and self._key in keys
            self._choose(keys, keys.index(self._key) if known else self._index)
