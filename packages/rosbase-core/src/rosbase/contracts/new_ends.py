"""News of the topics of a backend: each end that a node creates, before its first message."""

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from rosbase.contracts.graph import TopicEnd

__all__ = ["NewEnds"]

_Listener: TypeAlias = "Callable[[TopicEnd], object]"


class NewEnds:
    """Tells listeners of new publishers and subscriptions.

    So whoever adds a tap to each topic misses no message. Without a listener, creating an end costs
    one test more.
    """

    def __init__(self) -> None:
        # Replaced, so that a backend tells without a lock.
        self._listeners: tuple[_Listener, ...] = ()

    def add(self, listener: _Listener) -> None:
        """Call `listener(end)` for each end that is created from now on.

        It is called on the thread that creates the end, before that call returns. It may add taps.
        It must not raise, and may not wait.
        """
        self._listeners = (*self._listeners, listener)

    def remove(self, listener: _Listener) -> None:
        """Call the listener no more. Do nothing if it is not called."""
        self._listeners = tuple(one for one in self._listeners if one != listener)

    def tell(self, describe: "Callable[[], TopicEnd]") -> None:
        """Tell of a new end. For backends, which hold no lock meanwhile.

        Args:
            describe: Returns the end; called only if anybody listens.
        """
        if self._listeners:
            end = describe()
            for listener in self._listeners:
                listener(end)
