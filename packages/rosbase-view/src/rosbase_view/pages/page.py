"""Contract of a page: rows to choose from, and details of the chosen one."""

from collections.abc import Hashable, Sequence
from typing import Protocol

from rosbase_view.drawing.lines import Line
from rosbase_view.source import Change, Gaze

__all__ = ["SCROLL_STEP", "Edit", "Page", "Pane"]

SCROLL_STEP = 5
"""Lines by which a key scrolls the details."""


class Pane(Protocol):
    """Size of a pane, and the time."""

    @property
    def width(self) -> int:
        """Columns."""
        ...

    @property
    def height(self) -> int:
        """Rows."""
        ...

    @property
    def now_ns(self) -> int:
        """Monotonic time."""
        ...


class Edit(Protocol):
    """A value that the user is to edit."""

    @property
    def title(self) -> str:
        """Name of the value, and what it may be."""
        ...

    @property
    def text(self) -> str:
        """Value before."""
        ...

    def change(self, text: str) -> Change:
        """Return the change that the user has written."""
        ...


class Page(Protocol):
    """A subject of the view."""

    title: str
    hints: Sequence[tuple[str, str]]
    """Own keys, each with its action."""
    follows: bool
    """Whether the cursor stays at the end while rows are added, until it is moved away."""

    detail_rows: int
    """Rows that the details should have below a long list."""

    def keys(self) -> Sequence[Hashable]:
        """Return the rows, each by something that stays the same while it is known."""
        ...

    def first_choice(self) -> Hashable | None:
        """Return the row to begin with; None if there is none."""
        ...

    def head(self, width: int) -> Line:
        """Return the titles of the columns."""
        ...

    def row(self, key: Hashable, pane: Pane, *, is_chosen: bool) -> Line:
        """Return a row, which need not be as wide as the pane."""
        ...

    def detail(self, key: Hashable | None, pane: Pane, first: int) -> list[Line]:
        """Return the details of the chosen row, from a line on."""
        ...

    def gaze(self, key: Hashable | None) -> Gaze:
        """Return what the source should tell of the chosen row."""
        ...

    def press(self, key: str, chosen: Hashable | None) -> Change | Edit | int | None:
        """Take a key of the keyboard: return a change, an edit, the number of a page, or None."""
        ...
