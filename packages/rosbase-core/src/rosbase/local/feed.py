"""A topic that a recording publishes in place of the program."""

from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

from rosbase.local.endpoints import LocalSubscription

__all__ = ["Feed"]


class Feed:
    """Delivers to the subscriptions of one topic, and keeps the last messages for later ones."""

    def __init__(self, depth: int) -> None:
        """Begin with nothing.

        Args:
            depth: Number of messages to keep.
        """
        self._kept: deque[Any] = deque(maxlen=depth)

    def kept_messages(self) -> list[Any]:
        """Return what is kept, the oldest first."""
        return list(self._kept)

    def welcome(self, subscription: LocalSubscription) -> None:
        """Deliver what is kept to a new subscription, if it asks for it."""
        if subscription.profile.is_latched:
            for message in self.kept_messages()[-subscription.depth :]:
                subscription.deliver(message)

    def deliver(
        self,
        message: Any,
        subscriptions: Iterable[LocalSubscription],
        taps: Iterable[Callable[[Any], None]],
    ) -> None:
        """Deliver a message, and keep it."""
        for subscription in subscriptions:
            subscription.deliver(message)
        for take in taps:
            take(message)
        self._kept.append(message)
