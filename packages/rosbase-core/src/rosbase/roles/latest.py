"""The latest value: the last message of a topic, and how long ago it arrived."""

import math
from collections.abc import Callable
from typing import Generic, TypeVar

from rosbase.contracts.backend import Subscription

__all__ = ["Latest"]

MessageT = TypeVar("MessageT")

_NS_PER_S = 1e9


class Latest(Generic[MessageT]):
    """The latest message of a topic. `BaseNode.latest` makes it.

    The age counts from the arrival of the message, not from its stamp. So it says whether the
    source still sends, for messages without a stamp too, and neither a date that is set nor the
    clock of another machine changes it. It counts on the time that timers follow: monotonic time,
    or `/clock` while `use_sim_time` is true. To know how old a measurement is, compare its stamp
    with `get_clock().now()`.

    Read it from any thread.
    """

    __slots__ = ("_last", "_now_ns", "_seen", "subscription")

    def __init__(
        self,
        subscribe: Callable[[Callable[[MessageT], None]], Subscription[MessageT]],
        now_ns: Callable[[], int],
    ) -> None:
        """Subscribe.

        Args:
            subscribe: Creates a subscription with the given callback.
            now_ns: Returns the time that the node's timers follow, in nanoseconds.
        """
        self._now_ns = now_ns
        # Message and time as one object, so that another thread sees both or neither.
        self._last: tuple[MessageT, int] | None = None
        self._seen: tuple[MessageT, int] | None = None
        self.subscription = subscribe(self._keep)
        """Subscription of the topic, for `destroy_subscription`."""

    def __repr__(self) -> str:
        age = "no message" if self._last is None else f"age {self.age_s:.3g} s"
        return f"<Latest of {self.subscription.topic}: {age}>"

    @property
    def value(self) -> MessageT | None:
        """Latest message; None before the first."""
        return None if self._last is None else self._last[0]

    @property
    def age_s(self) -> float:
        """Seconds since the latest message arrived; infinite before the first.

        A message arrives when the node handles it, between two ticks of the main loop. The age is
        infinite too if simulated time has been set back since.
        """
        last = self._last
        if last is None:
            return math.inf
        age_ns = self._now_ns() - last[1]
        return age_ns / _NS_PER_S if age_ns >= 0 else math.inf

    def time_since_last_msg(self) -> float:
        """Return `age_s`, under the name of programs written for ros_base."""
        return self.age_s

    def is_fresh(self, timeout_s: float) -> bool:
        """Return whether a message arrived within the last `timeout_s` seconds."""
        age_s = self.age_s
        return age_s <= timeout_s and age_s != math.inf

    def is_new(self) -> bool:
        """Return whether a message arrived since the last call: true once per new message.

        Of several messages between two calls, only the latest counts.
        """
        last = self._last
        if last is self._seen:
            return False
        self._seen = last
        return True

    def _keep(self, message: MessageT) -> None:
        self._last = (message, self._now_ns())
