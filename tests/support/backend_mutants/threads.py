"""What is wrong with threads."""

import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from rosbase.contracts.backend import BackendOptions, Publisher, Subscription, Timer
from rosbase.errors import BackendError
from rosbase.local import LocalBackend
from support.backend_mutants.changed import Changed, breaks, too_long


@breaks("calls-come-from-any-thread")
class CallsTheLastFirst(LocalBackend):
    call_soon: Any

    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.call_soon = self.executor.ready.appendleft


@breaks("calls-come-from-any-thread")
class CallsSoonerThanSoon(LocalBackend):
    call_soon: Any

    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.call_soon = lambda function: function()


@breaks("callbacks-run-on-the-spinning-thread")
class CallsBackAtOnce(Changed):
    def schedule(self, function: Callable[[], object]) -> None:
        function()


@breaks("callbacks-run-on-the-spinning-thread")
class CallsBackOnAThreadOfItsOwn(Changed):
    def callback(self, callback: Callable[[Any], object]) -> Callable[[Any], object]:
        def call(message: Any) -> None:
            thread = threading.Thread(target=callback, args=(message,))
            thread.start()
            thread.join()

        return call


@breaks("messages-wake-the-spinner")
class LetsTheSpinnerSleep(Changed):
    def schedule(self, function: Callable[[], object]) -> None:
        self.executor.ready.append(function)


@breaks("timers-wake-the-spinner")
class LetsTheSpinnerSleepOverTimers(LocalBackend):
    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        self.executor._sleeping = False
        return super().create_timer(period_s, callback)


@breaks("errors-reach-the-spinner")
class SwallowsErrors(Changed):
    def callback(self, callback: Callable[[Any], object]) -> Callable[[Any], object]:
        def call(message: Any) -> None:
            with suppress(Exception):
                callback(message)

        return call


@breaks("publishing-is-for-any-thread")
class HearsItsOwnThreadOnly(Changed):
    def send(self, publisher: Publisher[Any], message: Any) -> None:
        if threading.current_thread() is self.thread:
            publisher.publish(message)


@breaks("publishing-waits-for-nobody")
class WaitsForRoom(Changed):
    def send(self, publisher: Publisher[Any], message: Any) -> None:
        if message.x == 1.0 and all(self.waiting()):
            too_long()
        publisher.publish(message)


@breaks("destroying-is-for-any-thread")
class DestroysOnItsOwnThread(Changed):
    def destroy_subscription(self, subscription: Subscription[Any]) -> None:
        if threading.current_thread() is not self.thread:
            raise BackendError("not on this thread")
        super().destroy_subscription(subscription)


@breaks("destroying-is-for-any-thread")
class OverhearsOtherThreads(Changed):
    def destroy_subscription(self, subscription: Subscription[Any]) -> None:
        if threading.current_thread() is self.thread:
            super().destroy_subscription(subscription)


class KnowsItsCallbacks(Changed):
    """Knows when it is called from within a callback."""

    is_calling = False

    def callback(self, callback: Callable[[Any], object]) -> Callable[[Any], object]:
        def call(message: Any) -> None:
            self.is_calling = True
            try:
                callback(message)
            finally:
                self.is_calling = False

        return call


@breaks("callbacks-may-use-the-backend")
class WaitsForItsOwnCallback(KnowsItsCallbacks):
    def send(self, publisher: Publisher[Any], message: Any) -> None:
        if self.is_calling:
            too_long()
        publisher.publish(message)


@breaks("callbacks-may-use-the-backend")
class LosesWhatACallbackPublishes(KnowsItsCallbacks):
    def send(self, publisher: Publisher[Any], message: Any) -> None:
        if not self.is_calling:
            publisher.publish(message)


@breaks("callbacks-may-use-the-backend")
class CreatesOnlyOutsideCallbacks(KnowsItsCallbacks):
    def create_publisher(self, msg_type: Any, topic: Any, qos_profile: Any) -> Publisher[Any]:
        if self.is_calling:
            raise BackendError("not from within a callback")
        return super().create_publisher(msg_type, topic, qos_profile)


@breaks("errors-reach-the-spinner")
class ForgetsWhatWaitsAfterAnError(Changed):
    def callback(self, callback: Callable[[Any], object]) -> Callable[[Any], object]:
        def call(message: Any) -> None:
            try:
                callback(message)
            except Exception:
                for queue in self.waiting():
                    queue.clear()
                raise

        return call
