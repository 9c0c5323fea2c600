"""Contract for what feeds a view: running programs, or a recording."""

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Protocol, TypeAlias

from attrs import frozen

from rosbase_view.reports import NodeKey, Report, TopicKey

__all__ = ["Change", "ChangeState", "Gaze", "Pace", "Playback", "SetParameter", "Source"]


class Pace(Enum):
    """Which messages of a topic a view needs."""

    NEWEST = "newest"
    """The newest one, 20 a second at most."""
    ALL = "all"
    """Each one. If nobody takes them, the oldest are left out, and `Heard.dropped` counts them."""


@frozen
class Gaze:
    """The topics and nodes that the user looks at, so that a source asks for nothing else."""

    topics: frozenset[TopicKey] = frozenset()
    """Topics whose messages are shown."""
    nodes: frozenset[NodeKey] = frozenset()
    """Nodes whose parameters and transitions are shown."""
    pace: Pace = Pace.NEWEST


@frozen
class SetParameter:
    """Set a parameter to a value as the user wrote it."""

    node: NodeKey
    name: str
    text: str


@frozen
class ChangeState:
    """Run a transition of a lifecycle node."""

    node: NodeKey
    transition: str


Change: TypeAlias = SetParameter | ChangeState


class Playback(Protocol):
    """Moves through a recording; each call is followed by a report of the new `Position`."""

    def play(self) -> None:
        """Go on; from the beginning, if the end was reached."""
        ...

    def pause(self) -> None:
        """Stand still."""
        ...

    def seek(self, time_ns: int) -> None:
        """Go to a time, in nanoseconds since 1970; to the nearest end if it lies outside."""
        ...

    def set_rate(self, rate: float) -> None:
        """Set the speed; 1 is the speed of the recording."""
        ...


class Source(Protocol):
    """Feeds a view. All methods are called on one thread."""

    @property
    def can_change(self) -> bool:
        """Return whether `change` does anything: a recording cannot be changed."""
        ...

    @property
    def playback(self) -> Playback | None:
        """Return the controls of a recording; None for what runs."""
        ...

    def start(self, on_news: Callable[[], object] | None = None) -> None:
        """Begin to collect reports. Called once.

        Args:
            on_news: Called on any thread when there is something to take. It must be quick.
        """
        ...

    def take(self) -> Sequence[Report]:
        """Return what was reported since the last call, in an order that the model can take.

        It does not wait. What nobody takes must not add up: the newest survey and the newest
        messages replace the ones before, counts are added, and old records of the log are left
        out.
        """
        ...

    def look_at(self, gaze: Gaze) -> None:
        """Follow the user's eyes. Called when they move."""
        ...

    def schema_of(self, topic: TopicKey) -> tuple[str, str]:
        """Return the type of the messages, and its schema; may wait for a second.

        Raises:
            ControlError: There is no such topic, its messages have no schema, or its program does
                not answer.
        """
        ...

    def change(self, change: Change) -> None:
        """Begin a change; its result is a `Said`."""
        ...

    def close(self) -> None:
        """End collecting. Idempotent."""
        ...
