"""The ends of a recorded backend: what threads outside hand to them comes in as entries."""

from collections.abc import Callable
from functools import partial
from typing import Any

from rosbase.contracts.guarded_services import GuardedServer
from rosbase.contracts.service_server import ServiceServer
from rosbase.contracts.services import ServiceType
from rosbase.entries.conductor import Conductor
from rosbase.entries.entrance import Entrance
from rosbase.entries.kinds import Kind
from rosbase.local.endpoints import LocalPublisher, LocalSubscription
from rosbase.local.guarded_ends import FindForm, GuardedSubscription, guarded_publisher
from rosbase.qos import QoSProfile

__all__ = ["Guard"]


class Guard:
    """Makes the ends of one backend. Its functions take what the plain classes take."""

    def __init__(self, conductor: Conductor, find_form: FindForm) -> None:
        """Prepare for a backend.

        Args:
            conductor: The conductor of its program.
            find_form: Returns the form of a class of messages; TypeError if it has no schema.
        """
        self.conductor = conductor
        self._find_form = find_form

    def make_publisher(self, topic: str, msg_type: type, profile: QoSProfile) -> LocalPublisher:
        """Create a publisher."""
        return guarded_publisher(self.conductor, self._find_form, topic, msg_type, profile)

    def subscription_of(self, msg_type: type) -> Callable[..., LocalSubscription]:
        """Return what creates subscriptions to messages of a class."""

        def make(
            topic: str,
            callback: Callable[[Any], object],
            profile: QoSProfile,
            schedule: Callable[[Callable[[], object]], None],
        ) -> LocalSubscription:
            find_form = partial(self._find_form, msg_type)
            entrance = partial(Entrance, self.conductor, Kind.ARRIVE, topic, find_form)
            return GuardedSubscription(topic, callback, profile, schedule, entrance)

        return make

    def server_of(self, srv_type: ServiceType[Any, Any]) -> Callable[..., ServiceServer]:
        """Return what creates services of a type."""
        kind: Any = srv_type.Request
        find_form = partial(self._find_form, kind)
        return partial(GuardedServer, conductor=self.conductor, find_form=find_form)

    def note_outside(self, what: str) -> None:
        """Spoil the recording if a thread of the program's own changes the program.

        Args:
            what: What it does, such as `sets parameters`.
        """
        if not self.conductor.is_inside:
            self.conductor.spoil(f"a thread of the program's own {what}")
