"""State that all nodes of a replayed program share."""

from collections.abc import Callable
from typing import Any

from attrs import define, field

from rosbase.clock import Clock
from rosbase.contracts.graph import TopicEnd
from rosbase.contracts.message_format import MessageFormat, message_format
from rosbase.contracts.new_ends import NewEnds
from rosbase.contracts.tap import Tap
from rosbase.entries.conductor import Conductor
from rosbase.errors import BackendError
from rosbase.local.replayed.parameters import ReplayedParameters
from rosbase.local.replayed.services import ReplayedClient, ReplayedServer
from rosbase.local.replayed.topics import ReplayedPublisher, ReplayedSubscription, Taps
from rosbase.logger import RosbaseLogger
from rosbase.plugins import installed_plugins
from rosbase.runtime.executor import Executor

__all__ = ["ReplayedProgram"]


@define(eq=False)
class ReplayedProgram:
    """The part of a backend that its nodes have in common."""

    conductor: Conductor
    """The replay."""
    machine: Clock
    """The clock below the program's."""
    executor: Executor
    new_ends: NewEnds
    """Tells of new publishers and subscriptions."""
    taps: Taps = field(init=False, factory=dict)
    nodes: dict[str, ReplayedParameters] = field(init=False, factory=dict)
    """Parameters of the nodes, by their names."""
    publishers: list[ReplayedPublisher] = field(init=False, factory=list)
    subscriptions: list[ReplayedSubscription] = field(init=False, factory=list)
    services: dict[str, ReplayedServer] = field(init=False, factory=dict)
    """Services, by their full names."""
    clients: list[ReplayedClient[Any, Any]] = field(init=False, factory=list)
    ends: list[TopicEnd] = field(init=False, factory=list)
    """All publishers and subscriptions."""
    is_closed: bool = field(init=False, default=False)

    def form(self, msg_type: Any) -> MessageFormat:
        """Return the format of a class of messages; one of the middleware needs its packages.

        Raises:
            BackendError: They are not installed.
        """
        try:
            return message_format(msg_type)
        except TypeError:
            try:
                return installed_plugins().message_format(msg_type)
            except TypeError as error:
                raise BackendError(str(error)) from None

    def check_open(self) -> None:
        """Check that the backend has not been closed.

        Raises:
            BackendError: It has.
        """
        if self.is_closed:
            raise BackendError("the backend is closed")

    def add_end(self, end: TopicEnd) -> None:
        """Note a new publisher or subscription."""
        self.ends.append(end)
        self.new_ends.tell(lambda: end)

    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        """Hear what is published on the topic of that full name."""
        tap = Tap(topic, on_message, self._remove_tap, self._fail_tap)
        self.taps[topic] = (*self.taps.get(topic, ()), tap)
        return tap

    def hear(self, topic: str, data: bytes) -> None:
        """Hand a message to the taps of a topic."""
        for tap in self.taps.get(topic, ()):
            tap.take(data)

    def _remove_tap(self, tap: Tap) -> None:
        self.taps[tap.topic] = tuple(o for o in self.taps.get(tap.topic, ()) if o is not tap)

    def _fail_tap(self, tap: Tap, error: Exception) -> None:
        RosbaseLogger("replay").error(f"{tap.topic}: a tap has ended, because it raised {error}")
        self._remove_tap(tap)
