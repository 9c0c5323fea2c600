"""What is wrong with quality of service."""

import threading
from collections.abc import Callable
from typing import Any

from attrs import evolve

from rosbase.contracts.backend import BackendOptions, Publisher
from rosbase.local import Bus, LocalBackend
from rosbase.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
    as_profile,
)
from support.backend_mutants.changed import Changed, breaks


@breaks("depth-drops-the-oldest")
class KeepsOneTooMany(Changed):
    def asked(self, profile: Any) -> Any:
        return profile + 1


@breaks("depth-drops-the-oldest")
class ForgetsWhatItDrops(Changed):
    def send(self, publisher: Publisher[Any], message: Any) -> None:
        for queue in self.waiting():
            while len(queue) == queue.maxlen:
                queue.popleft()
        publisher.publish(message)


@breaks("depth-drops-the-oldest")
class DropsTheNewest(Changed):
    def send(self, publisher: Publisher[Any], message: Any) -> None:
        for subscription in self.all_subscriptions():
            if len(subscription._queue) == subscription.depth:
                subscription._dropped += 1
                return
        publisher.publish(message)


@breaks("keep-all-drops-none")
class KeepsTheLastOnly(Changed):
    def asked(self, profile: Any) -> Any:
        return evolve(profile, history=HistoryPolicy.KEEP_LAST)


@breaks("late-subscriptions-get-what-was-kept")
class KeepsOneTooManyForLater(Changed):
    def offered(self, profile: Any) -> Any:
        return evolve(profile, depth=profile.depth + 1)


@breaks("late-subscriptions-miss-none")
class ListensAMomentLater(Changed):
    def create_subscription(
        self, msg_type: Any, topic: Any, callback: Callable[[Any], object], qos_profile: Any
    ) -> Any:
        subscription: Any = super().create_subscription(msg_type, topic, callback, qos_profile)
        threading.Event().wait(0.005)
        subscription._queue.clear()
        return subscription


@breaks("volatile-gets-only-the-new")
class AsksForWhatWasKept(Changed):
    def asked(self, profile: Any) -> Any:
        return evolve(as_profile(profile, ""), durability=DurabilityPolicy.TRANSIENT_LOCAL)


@breaks("ended-publishers-are-silent")
@breaks("kept-messages-end-with-the-publisher")
class KeepsForEver(LocalBackend):
    def destroy_publisher(self, publisher: Publisher[Any]) -> None:
        pass


@breaks("weak-offers-are-not-heard")
class AsksForNothing(Changed):
    def asked(self, profile: Any) -> Any:
        return QoSProfile(1000, reliability=ReliabilityPolicy.BEST_EFFORT)


@breaks("weak-offers-are-warned-of")
class WarnsOfNothing(LocalBackend):
    class SilentBus(Bus):
        def _warn(self, name: str, reasons: object) -> None:
            pass

    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options, self.SilentBus())


@breaks("wrong-profiles-are-errors")
class TakesAnyProfile(Changed):
    def asked(self, profile: Any) -> Any:
        return profile if isinstance(profile, QoSProfile) else 10

    offered = asked


@breaks("handled-messages-are-not-kept")
class KeepsEveryMessage(Changed):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.kept: list[Any] = []

    def send(self, publisher: Publisher[Any], message: Any) -> None:
        self.kept.append(message)
        publisher.publish(message)
