"""State of the page, and presses of its buttons. Pure."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

from attrs import field, frozen

from rosbase import WireError
from rosbase_view.known import Known
from rosbase_view.reports import Heard, NodeKey, Position, Report, Said, Survey, TopicKey
from rosbase_view.source import Change, ChangeState, Gaze
from rosbase_view.web import health
from rosbase_view.web.choice import Choice
from rosbase_view.web.health import Health, Status
from rosbase_view.web.quantities import (
    IMU,
    MAGNETIC_FIELD,
    Quantity,
    Rotation,
    quantities,
    rotation,
)
from rosbase_view.web.trace import Trace

__all__ = ["TRANSITIONS", "ChooseNode", "ChooseTopic", "Model", "Picture", "Press", "RunTransition"]

TRANSITIONS = ("configure", "activate", "deactivate", "cleanup", "shutdown")
"""Transitions that a user runs, in the order of their buttons."""

# Without a message for so long, the orientation is out of date.
_FRESH_NS = 2_000_000_000


@frozen
class ChooseTopic:
    """The user has chosen an Imu, by its label."""

    label: str


@frozen
class ChooseNode:
    """The user has chosen a lifecycle node, by its label."""

    label: str


@frozen
class RunTransition:
    """The user has pressed the button of a transition."""

    transition: str


Press: TypeAlias = ChooseTopic | ChooseNode | RunTransition


@frozen
class Picture:
    """All that the page shows."""

    topics: Sequence[str] = ()
    topic: str = ""
    nodes: Sequence[str] = ()
    node: str = ""
    rotation: Rotation | None = None
    """Orientation of the board; None if it is unknown, or not known any more."""
    is_there: bool = False
    """Whether the topic exists."""
    is_fresh: bool = True
    """Whether a message has come so lately that it tells of now."""
    rate_hz: float | None = None
    age_ns: int | None = None
    statuses: Sequence[Status] = ()
    lifecycle: str = ""
    """State of the chosen node; empty if there is no such node."""
    offered: frozenset[str] = frozenset()
    """Transitions that the chosen node offers."""
    traces: Mapping[Quantity, Trace] = field(factory=dict)
    said: Said | None = None
    has_programs: bool = False
    is_answering: bool = True
    """Whether the program of the topic answers."""
    position: Position | None = None
    """Where a recording is; None for what runs."""


class Model:
    """Takes the reports of a source and the presses of the users."""

    def __init__(self) -> None:
        """Begin with nothing known."""
        self.known = Known()
        self._topics, self._nodes = Choice(), Choice()
        self._health = Health()
        self._traces: dict[Quantity, Trace] = {}
        self._shown: TopicKey | None = None
        self._rotation: Rotation | None = None
        self._heard_ns = 0

    def take(self, reports: Iterable[Report], now_ns: int) -> None:
        """Take reports, at a monotonic time."""
        for report in reports:
            self.known.take((report,), now_ns)
            if isinstance(report, Survey):
                self._learn()
            elif isinstance(report, Heard):
                try:
                    self._hear(report, now_ns)
                except WireError as error:
                    said = Said(f"cannot read {report.topic[0]}: {error}", is_error=True)
                    self.known.take((said,), now_ns)

    def press(self, press: Press, now_ns: int) -> Change | None:
        """Take the press of a user; return the change that the source should make."""
        if isinstance(press, ChooseTopic):
            self._topics.choose(press.label)
            self._follow()
        elif isinstance(press, ChooseNode):
            self._nodes.choose(press.label)
        elif (node := self._nodes.key) is not None:
            return self._run(node, press.transition, now_ns)
        return None

    @property
    def gaze(self) -> Gaze:
        """Topics and nodes that the page needs."""
        node = self._nodes.key
        return Gaze(
            topics=frozenset(self._needed()), nodes=frozenset(() if node is None else (node,))
        )

    def picture(self, now_ns: int) -> Picture:
        """Return what the page shows at a monotonic time."""
        key, node = self._topics.key, self._nodes.key
        state = self.known.topics.get(key) if key is not None else None
        age_ns = None if state is None else state.age_ns(now_ns)
        # A recording that stands still shows its last message for as long as it does.
        is_recording = self.known.position is not None
        is_fresh = is_recording or now_ns - self._heard_ns <= _FRESH_NS
        row = None if node is None else self.known.nodes.get(node)
        return Picture(
            topics=self._topics.labels,
            topic=self._topics.label,
            nodes=self._nodes.labels,
            node=self._nodes.label,
            rotation=self._rotation if is_fresh and state is not None else None,
            is_there=state is not None,
            is_fresh=is_fresh,
            rate_hz=None if state is None else state.rate_hz(now_ns),
            age_ns=age_ns,
            statuses=self._health.statuses(None if is_recording else now_ns),
            lifecycle="" if row is None else row.lifecycle or "",
            offered=frozenset() if node is None else frozenset(self._offered(node)),
            traces=self._traces,
            said=self.known.said(now_ns),
            has_programs=bool(self.known.processes),
            is_answering=key is None or key[1] not in self.known.silent,
            position=self.known.position,
        )

    def _learn(self) -> None:
        """Offer what the newest survey has found."""
        known = self.known
        imus = [key for key, one in known.topics.items() if IMU in one.topic["types"]]
        nodes = [key for key, one in known.nodes.items() if one.lifecycle is not None]
        self._topics.offer(imus, known.programs)
        self._nodes.offer(nodes, known.programs)
        self._follow()

    def _run(self, node: NodeKey, transition: str, now_ns: int) -> Change | None:
        # The page shows only what is offered, but perhaps not any more.
        is_offered = transition in self._offered(node)
        text = f"{transition} of {node[0]} ..."
        if not is_offered:
            text = f"{node[0]} does not offer {transition} now"
        # Until the result comes, which may take long.
        self.known.take((Said(text, is_error=not is_offered),), now_ns)
        return ChangeState(node, transition) if is_offered else None

    def _follow(self) -> None:
        """Begin anew if another Imu is chosen: with its own curves, and with its own node."""
        key = self._topics.key
        if key is None or key == self._shown:
            return
        self._shown = key
        self._traces, self._health, self._rotation = {}, Health(), None
        for end in self.known.topics[key].topic["publishers"]:
            self._nodes.prefer((end["node"], end["pid"]))

    def _needed(self) -> Iterable[TopicKey]:
        """Return the chosen Imu, what else its node measures, and the health of its programs."""
        key = self._topics.key
        if key is None:
            return
        yield key
        owners = self._owners(key)
        for other, one in self.known.topics.items():
            if other[1] != key[1]:
                # Of programs that do not hear each other.
                continue
            is_health = other[0] == health.TOPIC and health.DIAGNOSTICS in one.topic["types"]
            is_field = MAGNETIC_FIELD in one.topic["types"] and owners & self._owners(other)
            if is_health or is_field:
                yield other

    def _owners(self, key: TopicKey) -> set[NodeKey]:
        return {(end["node"], end["pid"]) for end in self.known.topics[key].topic["publishers"]}

    def _hear(self, heard: Heard, now_ns: int) -> None:
        if heard.topic not in self._needed():
            # Asked for before the user chose another one.
            return
        if heard.topic == self._shown and heard.type == IMU:
            self._rotation, self._heard_ns = rotation(heard.message), now_ns
        if heard.type == health.DIAGNOSTICS:
            self._health.take(heard.message, now_ns)
        elif heard.stamp_ns is not None:
            for quantity, values in quantities(heard.type, heard.message).items():
                self._traces.setdefault(quantity, Trace()).add(heard.stamp_ns, values)

    def _offered(self, node: NodeKey) -> Sequence[str]:
        report = self.known.node_reports.get(node)
        return () if report is None else report.transitions
