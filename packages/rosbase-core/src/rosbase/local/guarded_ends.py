"""Publishers and subscriptions of a recorded program.

What other threads publish, and what comes from links and from other backends of the process, comes
in as an entry. On the thread that runs the program, they are as all others.
"""

from collections.abc import Callable
from functools import cache, partial
from threading import get_ident
from typing import Any, TypeAlias

from rosbase.entries.conductor import Conductor
from rosbase.entries.entrance import Entrance, Form
from rosbase.entries.kinds import Kind
from rosbase.local.endpoints import LocalPublisher, LocalSubscription, publisher_class
from rosbase.qos import QoSProfile

__all__ = ["FindForm", "GuardedSubscription", "guarded_publisher"]

FindForm: TypeAlias = Callable[[type], Form]
"""Returns the form of a class of messages. TypeError if it has no schema."""


class GuardedSubscription(LocalSubscription):
    """A subscription whose messages from outside are entries."""

    __slots__ = ("_entrance", "_turn")

    def __init__(
        self,
        topic: str,
        callback: Callable[[Any], object],
        profile: QoSProfile,
        schedule: Callable[[Callable[[], object]], None],
        entrance: Callable[[Callable[[Any], object]], Entrance],
    ) -> None:
        """Prepare a subscription.

        Args:
            topic: As for `LocalSubscription`.
            callback: Likewise.
            profile: Likewise.
            schedule: Likewise.
            entrance: Returns its entrance, for a function that takes messages in a replay.
        """
        super().__init__(topic, callback, profile, schedule)
        self._entrance = entrance(super().deliver)
        self._turn = self._entrance.turn

    # These need no lock. Only the thread with the turn adds and removes messages, and subscriptions
    # of a program are never resized. Another thread may close one, but adds nothing.

    def deliver(self, message: Any) -> None:
        """Queue a message, from any thread; drop the oldest if the queue is full."""
        if self._turn.owner != get_ident():
            self._entrance.let_in(message, super().deliver)
        elif self._put(message):
            self._schedule(self.handle_one)

    def handle_one(self) -> None:
        """Call the callback with the oldest message. For the spinning thread."""
        try:
            message = self._queue.popleft()
        except IndexError:
            return
        if not self._closed:
            self._callback(message)


def guarded_publisher(
    conductor: Conductor, find_form: FindForm, topic: str, msg_type: type, profile: QoSProfile
) -> LocalPublisher:
    """Create a publisher whose messages of other threads are entries.

    Args:
        conductor: The conductor of the program.
        find_form: Finds the form of its messages.
        topic: As for `make_publisher`.
        msg_type: Likewise.
        profile: Likewise.
    """
    kind: Any = publisher_class(msg_type, profile)
    publisher: LocalPublisher = _guarded(kind)(topic, msg_type, profile)
    publisher._turn = conductor.turn  # type: ignore[attr-defined]  # which only this class has
    publisher._entrance = Entrance(  # type: ignore[attr-defined]  # likewise
        conductor,
        Kind.PUBLISH,
        topic,
        partial(find_form, msg_type),
        partial(kind.publish, publisher),
    )
    return publisher


@cache
def _guarded(kind: Any) -> Any:
    """Return a class of publishers as a guarded one."""
    publish_plainly = kind.publish

    class Guarded(kind):  # type: ignore[misc]  # one for each kind
        __slots__ = ("_entrance", "_turn")

        def publish(self, message: Any) -> None:
            """Queue the message for every matching subscription. Call it from any thread."""
            # A message of another type is refused as ever.
            if self._turn.owner == get_ident() or not isinstance(message, self._msg_type):
                publish_plainly(self, message)
            else:
                self._entrance.let_in(message, super().publish)

        @property
        def subscription_count(self) -> int:
            """Number of subscriptions that hear it, also of other processes."""
            count: int = self._entrance.ask(lambda: len(self._matching))
            return count

    return Guarded
