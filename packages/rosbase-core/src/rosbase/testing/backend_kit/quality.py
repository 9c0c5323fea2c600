"""Checks of quality of service: kept messages, and matching of offers and requests."""

import threading
from functools import partial
from typing import Any

from rosbase.contracts.backend import Backend
from rosbase.errors import BackendError
from rosbase.messages import String, Vector3
from rosbase.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosbase.testing.backend_kit.overheard import overhearing
from rosbase.testing.backend_kit.promises import promise
from rosbase.testing.backend_kit.rig import BackendRig, Listener, Talker
from rosbase.testing.promise import Promise
from rosbase.testing.resources import memory_growth

__all__ = ["QualityChecks"]

_NO_PROFILES: tuple[Any, ...] = (0, -1, True, 1.5, "sensor", None)
_KEEP_ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL)
_BEST_EFFORT = QoSProfile(reliability=ReliabilityPolicy.BEST_EFFORT)
_WAITING = 3
_LOST = 4
_MANY = 300
_LONG, _TIMES = 20_000, 100


def _latched(depth: int = 10, **policies: Any) -> QoSProfile:
    return QoSProfile(depth, durability=DurabilityPolicy.TRANSIENT_LOCAL, **policies)


# Offered and requested profiles: each offer is too weak.
_WEAK = {
    "BEST_EFFORT": (_BEST_EFFORT, QoSProfile()),
    "VOLATILE": (QoSProfile(), _latched()),
}


class QualityChecks(BackendRig):
    """Checks of depth, history, durability, and profiles that do not match."""

    def test_depth_drops_the_oldest(self) -> None:
        promised, backend = promise("depth-drops-the-oldest"), self.open()
        talker, listener = self.talker(backend), self.listener(backend, _WAITING)
        self.connect(promised, talker, listener)
        before = listener.subscription.dropped
        sent = self._flood(promised, talker, listener)
        dropped = listener.subscription.dropped - before
        self._await_last(promised, backend, listener, sent - 1)
        seen = f"of 0 to {sent - 1} it heard {listener.numbers}, and dropped is {dropped}"
        promised.require(listener.numbers[-_WAITING:] == list(range(sent))[-_WAITING:], seen)
        promised.require(len(listener.numbers) + dropped <= sent, seen)
        if self.capabilities.delivers_in_process:
            promised.require((len(listener.numbers), dropped) == (_WAITING, sent - _WAITING), seen)

    def test_keep_all_drops_none(self) -> None:
        promised, backend = promise("keep-all-drops-none"), self.open()
        talker, listener = self.talker(backend, _KEEP_ALL), self.listener(backend, _KEEP_ALL)
        self.connect(promised, talker, listener)
        talker.say(*range(_MANY))
        self.settle(promised, talker, listener)
        dropped = listener.subscription.dropped
        promised.require(
            listener.numbers == list(range(_MANY)) and not dropped,
            f"{len(listener.numbers)} of {_MANY} were heard, and dropped is {dropped}",
        )

    def test_handled_messages_are_not_kept(self) -> None:
        promised, backend = promise("handled-messages-are-not-kept"), self.open()
        heard: list[int] = []
        backend.create_subscription(
            String, self.topic, lambda message: heard.append(len(message.data)), 10
        )
        publisher = backend.create_publisher(String, self.topic, 10)

        def send_one() -> None:
            before = len(heard)
            # A new text each time, because the same object costs nothing when kept many times.
            publisher.publish(String(chr(97 + before % 26) * _LONG))
            self.wait(
                promised,
                lambda: len(heard) > before,
                lambda: "a message has not arrived",
                backend,
                meanwhile=lambda: None,
            )

        self.wait(
            promised,
            lambda: heard,
            lambda: "a subscription does not hear a publisher of its topic",
            backend,
            meanwhile=lambda: publisher.publish(String("found")),
        )
        with memory_growth() as growth:
            for _ in range(_TIMES):
                send_one()
            grown = growth()
        promised.require(
            grown < _LONG * _TIMES / 4, f"{grown} bytes more after {_LONG * _TIMES} in messages"
        )

    def test_late_subscriptions_get_what_was_kept(self) -> None:
        promised, backend = promise("late-subscriptions-get-what-was-kept"), self.open()
        talker = self.talker(backend, _latched(3))
        talker.say(1, 2, 3, 4)
        late = self.listener(backend, _latched())
        self._await_last(promised, backend, late, 4)
        talker.say(5)
        self.settle(promised, talker, late)
        promised.require(
            late.numbers == [2, 3, 4, 5],
            f"of 1 to 4, of which 3 were to be kept, and 5 it heard {late.numbers}",
        )

    def test_late_subscriptions_miss_none(self) -> None:
        promised, backend = promise("late-subscriptions-miss-none"), self.open()
        talker, ending = self.talker(backend, _latched(_MANY)), threading.Event()
        talker.say(0)

        def say_on() -> None:
            for number in range(1, _MANY - 10):
                if ending.wait(0.0005):
                    break
                talker.say(number)

        thread = threading.Thread(target=say_on, daemon=True)
        thread.start()
        late = [self.listener(backend, _latched(history=HistoryPolicy.KEEP_ALL)) for _ in range(5)]
        backend.executor.clock.sleep(0.02)
        ending.set()
        thread.join(self.patience_s)
        self.settle(promised, talker, *late)
        for listener in late:
            numbers = listener.numbers
            promised.require(
                numbers == list(range(len(numbers))),
                f"it heard {len(numbers)} messages, which are not 0 to {len(numbers) - 1} in order",
            )

    def test_volatile_gets_only_the_new(self) -> None:
        promised, backend = promise("volatile-gets-only-the-new"), self.open()
        talker = self.talker(backend, _latched())
        talker.say(1, 2, 3)
        late = self.listener(backend)
        self.connect(promised, talker, late)
        promised.require(not late.numbers, f"it heard {late.numbers}, from before it came")

    def test_kept_messages_end_with_the_publisher(self) -> None:
        promised, backend = promise("kept-messages-end-with-the-publisher"), self.open()
        first, second = (self.talker(backend, _latched()) for _ in range(2))
        first.say(1)
        second.say(2)
        backend.destroy_publisher(first.publisher)
        late = self.listener(backend, _latched())
        self.settle(promised, second, late)
        promised.require(
            late.numbers == [2],
            f"of 1, whose publisher was gone, and 2 it heard {late.numbers}",
        )

    def test_weak_offers_are_not_heard(self) -> None:
        promised, backend = promise("weak-offers-are-not-heard"), self.open()
        for name, (less, more) in _WEAK.items():
            topic = f"{self.topic}_{name}"
            weak, strong = Talker(backend, topic, less), Talker(backend, topic, more)
            demanding, easy = Listener(backend, topic, more), Listener(backend, topic, less)
            with overhearing():
                self.connect(promised, strong, demanding, easy)
                self.connect(promised, weak, easy)
            weak.say(1)
            self.settle(promised, weak, easy)
            self.settle(promised, strong, demanding)
            promised.require(not demanding.numbers, f"a publisher that offers {name} was heard")

    def test_weak_offers_are_warned_of(self) -> None:
        promised, backend = promise("weak-offers-are-warned-of"), self.open()
        for name, (less, more) in _WEAK.items():
            self._require_warning(promised, backend, name, less, more)

    def test_wrong_profiles_are_errors(self) -> None:
        promised, backend = promise("wrong-profiles-are-errors"), self.open()
        for wrong in _NO_PROFILES:
            for what, create in {
                "a publisher": self.talker,
                "a subscription": self.listener,
            }.items():
                doing = f"{what} with the profile {wrong!r}"
                self.refuses(
                    promised, BackendError, partial(create, backend, wrong), doing, repr(wrong)
                )

    def _require_warning(
        self, promised: Promise, backend: Backend, name: str, less: QoSProfile, more: QoSProfile
    ) -> None:
        topic = f"{self.topic}_{name}"
        with overhearing() as said:
            backend.create_publisher(Vector3, topic, less)
            backend.create_subscription(Vector3, topic, print, more)
            self.wait(
                promised,
                lambda: topic in said(),
                lambda: f"nothing names the topic on which {name} is offered",
                backend,
            )

    def _flood(self, promised: Promise, talker: Talker, listener: Listener) -> int:
        """Publish until some were dropped; return the number of published messages."""
        before, sent = listener.subscription.dropped, 0

        def say_one() -> None:
            nonlocal sent
            talker.say(sent)
            sent += 1
            # A message lost on the way to the process would not be counted.
            listener.backend.executor.clock.sleep(0.002)

        self.wait(
            promised,
            lambda: listener.subscription.dropped >= before + _LOST,
            lambda: (
                f"nobody handled any of {sent}, of which {_WAITING} may wait, and dropped is"
                f" {listener.subscription.dropped - before}"
            ),
            meanwhile=say_one,
        )
        return sent

    def _await_last(
        self, promised: Promise, backend: Backend, listener: Listener, last: int
    ) -> None:
        self.wait(
            promised,
            lambda: last in listener.numbers,
            lambda: f"it heard {listener.numbers}, without the last, {last}",
            backend,
        )
