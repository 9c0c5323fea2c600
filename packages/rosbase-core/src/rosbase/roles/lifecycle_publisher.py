"""A publisher of a lifecycle node."""

from typing import Generic, TypeVar

from rosbase.contracts.backend import Publisher

__all__ = ["LifecyclePublisher"]

MessageT_contra = TypeVar("MessageT_contra", contravariant=True)


class LifecyclePublisher(Generic[MessageT_contra]):
    """A publisher that sends only while its node is active."""

    __slots__ = ("_publisher", "_send", "is_enabled")

    def __init__(self, publisher: Publisher[MessageT_contra]) -> None:
        self._publisher = publisher
        self._send = publisher.publish
        self.is_enabled = False
        """Whether the node is active."""

    @property
    def topic(self) -> str:
        """Full name of the topic."""
        return self._publisher.topic

    @property
    def inner(self) -> Publisher[MessageT_contra]:
        """Publisher of the backend."""
        return self._publisher

    def publish(self, message: MessageT_contra) -> bool:
        """Hand the message on if the node is active; return whether it was sent.

        Raises:
            TypeError: See `rosbase.Publisher.publish`.
            ValueError: See `rosbase.Publisher.publish`.
        """
        return self.is_enabled and self._send(message) is not False
