"""Contract for what feeds the view: running programs, or a recording."""

from collections.abc import Sequence
from typing import Protocol, TypeAlias

from attrs import frozen

from rosbase_view.reports import NodeKey, Report, TopicKey

__all__ = ["Change", "ChangeState", "Gaze", "SetParameter", "Source"]


@frozen
class Gaze:
    """What the user looks at, so that a source asks for nothing else."""

    topic: TopicKey | None = None
    """Topic whose messages are shown."""
    node: NodeKey | None = None
    """Node whose parameters and transitions are shown."""


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


class Source(Protocol):
    """Feeds the view. All methods are called on one thread, and none of them waits."""

    @property
    def can_change(self) -> bool:
        """Return whether `change` does anything: a recording cannot be changed."""
        ...

    def start(self) -> None:
        """Begin to collect reports. Called once."""
        ...

    def take(self) -> Sequence[Report]:
        """Return what was reported since the last call, in an order that the model can take.

        What nobody takes must not add up: the newest survey and the newest message replace the
        ones before, counts are added, and old records of the log are left out.
        """
        ...

    def look_at(self, gaze: Gaze) -> None:
        """Follow the user's eyes. Called when they move."""
        ...

    def change(self, change: Change) -> None:
        """Begin a change; its result is a `Said`."""
        ...

    def close(self) -> None:
        """End collecting. Idempotent."""
        ...
