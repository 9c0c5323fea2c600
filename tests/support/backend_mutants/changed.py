"""The backend of the core, with places at which to change one thing."""

import threading
from collections.abc import Callable
from typing import Any, TypeVar

from rosbase.contracts.backend import Backend, BackendOptions, Publisher
from rosbase.local import Bus, LocalBackend

MUTANTS: dict[str, list[type[Backend]]] = {}
"""By the name of the promise that they break."""

LEFT_OPEN: list[int] = []
"""Descriptors that a mutant has not closed."""

PATIENCE_S = 0.3
"""How long the kit is to wait for these."""

BackendT = TypeVar("BackendT", bound=type[Backend])


def breaks(promise: str) -> Callable[[BackendT], BackendT]:
    """Enters a backend under the promise that it breaks."""

    def enter(mutant: BackendT) -> BackendT:
        MUTANTS.setdefault(promise, []).append(mutant)
        return mutant

    return enter


def too_long() -> None:
    """Takes longer than the kit waits, and ends by itself."""
    threading.Event().wait(2 * PATIENCE_S)


class Changed(LocalBackend):
    """The backend of the core, with places at which to change one thing."""

    def __init__(self, options: BackendOptions, bus: Bus | None = None) -> None:
        super().__init__(options, bus)
        self.thread = threading.current_thread()

    def create_publisher(self, msg_type: Any, topic: Any, qos_profile: Any) -> Publisher[Any]:
        kind, profile = self.msg_type(msg_type), self.offered(qos_profile)
        return ChangedPublisher(self, super().create_publisher(kind, self.name(topic), profile))

    def destroy_publisher(self, publisher: Any) -> None:
        super().destroy_publisher(getattr(publisher, "inner", publisher))

    def create_subscription(
        self, msg_type: Any, topic: Any, callback: Callable[[Any], object], qos_profile: Any
    ) -> Any:
        kind, profile = self.msg_type(msg_type), self.asked(qos_profile)
        subscription: Any = super().create_subscription(
            kind, self.name(topic), self.callback(callback), profile
        )
        subscription._schedule = self.schedule
        return subscription

    def msg_type(self, msg_type: type) -> type:
        return msg_type

    def name(self, topic: str) -> str:
        return topic

    def offered(self, profile: Any) -> Any:
        return profile

    def asked(self, profile: Any) -> Any:
        return profile

    def callback(self, callback: Callable[[Any], object]) -> Callable[[Any], object]:
        return callback

    def schedule(self, function: Callable[[], object]) -> None:
        self.call_soon(function)

    def send(self, publisher: Publisher[Any], message: Any) -> None:
        publisher.publish(message)

    def all_subscriptions(self) -> list[Any]:
        """Those of the whole process."""
        return [one for topic in self._bus._topics.values() for one in topic.subscriptions]

    def waiting(self) -> list[Any]:
        """What waits for each of them."""
        return [subscription._queue for subscription in self.all_subscriptions()]


class ChangedPublisher:
    def __init__(self, backend: Changed, inner: Publisher[Any]) -> None:
        self.backend = backend
        self.inner = inner
        self.topic = inner.topic

    def publish(self, message: Any) -> None:
        self.backend.send(self.inner, message)
