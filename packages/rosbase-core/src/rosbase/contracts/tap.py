"""A tap: hears the messages of a topic in this process, while somebody asks for them."""

from collections.abc import Callable
from typing import Any

__all__ = ["Tap"]


class Tap:
    """Hears the messages of one topic until it is closed, or its function raises.

    A backend hands each message to `take`, on the thread that publishes or receives it. Without a
    tap, its publishers and subscriptions do what they did before: they need not ask for taps.
    """

    __slots__ = ("_on_close", "_on_fault", "_on_message", "is_closed", "topic")

    def __init__(
        self,
        topic: str,
        on_message: Callable[[Any], object],
        on_close: "Callable[[Tap], object]",
        on_fault: "Callable[[Tap, Exception], object]",
    ) -> None:
        """Prepare a tap; the backend connects it.

        Args:
            topic: Full name of the topic.
            on_message: Called with each message.
            on_close: Disconnects the tap.
            on_fault: Called when `on_message` has raised, in the middle of publishing: it must not
                wait. It logs the error, and closes the tap, soon.
        """
        self.topic = topic
        """Full name of the topic."""
        self.is_closed = False
        """Whether it hears nothing any more."""
        self._on_message = on_message
        self._on_close = on_close
        self._on_fault = on_fault

    def take(self, message: Any) -> None:
        """Hand on a message. For backends."""
        try:
            self._on_message(message)
        except Exception as error:
            self._on_message = _nothing
            self._on_fault(self, error)

    def hand_to(self, on_message: Callable[[Any], object]) -> None:
        """Hand messages to another function from now on. Do nothing if the tap has ended."""
        if self._on_message is not _nothing:
            self._on_message = on_message

    def close(self) -> None:
        """Hear nothing any more, and leave publishers as they were before. Idempotent.

        Call it from any thread. A call that another thread is in may still end.
        """
        if not self.is_closed:
            self.is_closed = True
            self._on_message = _nothing
            self._on_close(self)


def _nothing(_message: Any) -> None:
    """Do nothing: the tap has ended."""
