"""Topics with rate, age and sparkline; the last message of the chosen one."""

from collections.abc import Hashable, Sequence

from rosbase import WireError
from rosbase_view.drawing.figures import age, counted, rate
from rosbase_view.drawing.glyphs import Glyphs
from rosbase_view.drawing.lines import Ink, Line, Span, clipped, line
from rosbase_view.drawing.table import Cell, Column
from rosbase_view.imu_picture import IMU, ImuPicture
from rosbase_view.known import Known
from rosbase_view.message_tree import Path, tree_rows
from rosbase_view.pages.base import BasePage
from rosbase_view.pages.page import SCROLL_STEP, Edit, Pane
from rosbase_view.reports import Heard, TopicKey
from rosbase_view.source import Change, Gaze
from rosbase_view.topic_state import TopicState

__all__ = ["TopicsPage"]

_SPARKLINE = 16
_COLUMNS = (
    Column("TOPIC", 16, share=1),
    Column("RATE", 9, is_right=True),
    Column("AGE", 5, is_right=True),
    Column("LAST 8 S", _SPARKLINE),
    Column("TYPE", 20, share=1),
)
_STALE_NS = 1_000_000_000
# Topics that most programs have, and on which little happens.
_OWN = {"lifecycle_msgs/msg/TransitionEvent", "diagnostic_msgs/msg/DiagnosticArray"}


class TopicsPage(BasePage):
    """The topics of all programs."""

    title = "topics"
    hints: Sequence[tuple[str, str]] = (("enter", "fold"),)
    detail_rows = 13
    columns = _COLUMNS

    def __init__(self, known: Known, glyphs: Glyphs) -> None:
        """Show what is known."""
        super().__init__(known, glyphs)
        self._picture = ImuPicture(glyphs)
        self._is_folded = False
        # The last message that was drawn, how it was drawn, and its lines.
        self._drawn: tuple[Heard, tuple[object, ...], list[Line]] | None = None
        self._rows: dict[tuple[TopicKey, bool], tuple[object, Line]] = {}

    def keys(self) -> Sequence[TopicKey]:
        """Return the topics by name."""
        return list(self.known.topics)

    def first_choice(self) -> Hashable | None:
        """Return the first Imu, which has a picture; else one that is not about the program."""
        return min(self.keys(), key=lambda key: _dullness(self.known.topics[key]), default=None)

    def row(self, key: Hashable, pane: Pane, *, is_chosen: bool) -> Line:
        """Return a row: the same one as before, if nothing that it shows has changed."""
        stamp = (self.cells(key, pane), pane.width)
        place = (_key(key), is_chosen)
        before = self._rows.get(place)
        if before is not None and before[0] == stamp:
            return before[1]
        drawn = super().row(key, pane, is_chosen=is_chosen)
        if len(self._rows) > 2 * len(self.known.topics):
            self._rows.clear()
        self._rows[place] = (stamp, drawn)
        return drawn

    def cells(self, key: Hashable, pane: Pane) -> Sequence[Cell]:
        """Return the cells of a row."""
        topic = self.known.topics[_key(key)]
        now_ns = self.known.time_ns(pane.now_ns)
        age_ns = topic.age_ns(now_ns)
        is_stale = age_ns is None or age_ns > _STALE_NS
        ink, drawn = (Ink.DIM, Ink.DIM) if is_stale else (Ink.PLAIN, Ink.DRAWING)
        return (
            Cell(_key(key)[0]),
            Cell(rate(topic.rate_hz(now_ns)), ink),
            Cell(age(age_ns), ink),
            Cell(topic.sparkline.draw(_SPARKLINE, self.glyphs), drawn),
            Cell(self._owner(key, ": ") + ", ".join(topic.topic["types"]), Ink.DIM),
        )

    def detail(self, key: Hashable | None, pane: Pane, first: int) -> list[Line]:
        """Return the ends of the topic, and its last message: a picture, if it has one."""
        if key is None:
            return []
        topic, heard = self.known.topics[_key(key)], self.known.heard.get(_key(key))
        ends = topic.topic
        lost = f", which lost {counted(topic.dropped, 'message')}" if topic.dropped else ""
        owner = f" of {name}" if (name := self._owner(key)) else ""
        lines = [
            line(Span(clipped(f"{_key(key)[0]}{owner}", pane.width), Ink.TITLE)),
            line(
                f"{counted(len(ends['publishers']), 'publisher')},"
                f" {counted(len(ends['subscriptions']), 'subscription')}{lost}"
                if self.known.position is None
                else ", ".join(ends["types"])
            ),
        ]
        if heard is None:
            return [*lines, line(Span("no message yet", Ink.DIM))]
        try:
            message = self._message_lines(heard, pane, first)
        except WireError as error:
            message = [line(Span(clipped(f"cannot be read: {error}", pane.width), Ink.BAD))]
        return [*lines, *message][: pane.height]

    def _owner(self, key: Hashable, ending: str = "") -> str:
        """Return the program, with an ending, if other programs have a topic of that name."""
        name = self.known.owners.get(_key(key))
        return "" if name is None else name + ending

    def _message_lines(self, heard: Heard, pane: Pane, first: int) -> list[Line]:
        """Return the lines of a message, without drawing it again if it is the same one."""
        how = (pane.width, pane.height, first, self._is_folded)
        if self._drawn is None or self._drawn[0] is not heard or self._drawn[1] != how:
            self._drawn = (heard, how, self._message(heard, pane, first))
        return self._drawn[2]

    def _message(self, heard: Heard, pane: Pane, first: int) -> list[Line]:
        room = pane.height - 2
        picture: list[Line] = []
        if heard.type == IMU and not first:
            # What is left is for the tree, which scrolls.
            picture = self._picture.draw(heard.message, pane.width, max(9, room - 6))
        folded: set[Path] = {(name,) for name in heard.message} if self._is_folded else set()
        # The first step down only leaves the picture behind.
        begin = max(0, first - SCROLL_STEP) if heard.type == IMU else first
        rows = tree_rows(heard.message, folded)[begin:]
        marks = {None: "  ", True: f"{self.glyphs.opened} ", False: f"{self.glyphs.closed} "}
        tree = [
            line(
                Span(f"{'  ' * row.depth}{marks[row.is_open]}{row.name} ", Ink.DIM),
                clipped(row.value, pane.width),
            )
            for row in rows[: max(0, room)]
        ]
        return [*picture, *tree]

    def gaze(self, key: Hashable | None) -> Gaze:
        """Look at the messages of the topic."""
        return Gaze(topics=frozenset(() if key is None else (_key(key),)))

    def press(self, key: str, chosen: Hashable | None) -> Change | Edit | int | None:
        """Fold or unfold the message."""
        if key == "enter":
            self._is_folded = not self._is_folded
        return None


def _dullness(topic: TopicState) -> int:
    types = topic.topic["types"]
    return 0 if IMU in types else 2 if set(types) & _OWN else 1


def _key(key: Hashable) -> TopicKey:
    assert isinstance(key, tuple)
    return key
