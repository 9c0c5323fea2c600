"""What is wrong at the end."""

import os
import threading
from collections.abc import Callable, Sequence
from typing import Any

from rosbase.contracts.backend import BackendOptions, Publisher, Timer
from rosbase.contracts.node_connection import Sender
from rosbase.errors import BackendError
from rosbase.local import LocalBackend
from rosbase.messages import Vector3
from support.backend_mutants.changed import LEFT_OPEN, Changed, breaks, too_long


@breaks("destroyed-subscriptions-are-silent")
class HandlesWhatWaited(LocalBackend):
    def destroy_subscription(self, subscription: Any) -> None:
        for publisher in self._publishers:
            publisher.disconnect(subscription)


@breaks("ended-publishers-are-silent")
class ComplainsOfTheEnd(Changed):
    def send(self, publisher: Publisher[Any], message: Any) -> None:
        if publisher not in self._publishers:
            raise BackendError("the publisher has been destroyed")
        publisher.publish(message)


@breaks("ended-publishers-are-silent")
class ComplainsAfterClose(Changed):
    def send(self, publisher: Publisher[Any], message: Any) -> None:
        if self._closed:
            raise BackendError("the backend is closed")
        publisher.publish(message)


@breaks("ended-publishers-are-silent")
class ComplainsOfSamples(LocalBackend):
    def prepared_sender(self, publisher: Any, template: Any, varying: Sequence[str]) -> Sender:
        send = super().prepared_sender(publisher, template, varying)

        def send_or_complain(*sample: Any) -> None:
            if publisher not in self._publishers:
                raise BackendError("the publisher has been destroyed")
            send(*sample)

        return send_or_complain


@breaks("destroying-twice-is-harmless")
class DestroysOnlyWhileOpen(LocalBackend):
    def destroy_timer(self, timer: Timer) -> None:
        if self._closed:
            raise BackendError("the backend is closed")
        super().destroy_timer(timer)


@breaks("destroying-twice-is-harmless")
class DestroysOnce(LocalBackend):
    def destroy_subscription(self, subscription: Any) -> None:
        self._subscriptions.remove(subscription)
        self._bus.remove_subscription(subscription)


@breaks("last-words-arrive")
class TakesItsWordsBack(Changed):
    def destroy_publisher(self, publisher: Any) -> None:
        super().destroy_publisher(publisher)
        for queue in self.waiting():
            queue.clear()


@breaks("last-words-outlive-the-backend")
class TakesItsWordsAlong(Changed):
    def close(self) -> None:
        super().close()
        for queue in self.waiting():
            queue.clear()


@breaks("closing-twice-is-harmless")
class ClosesOnce(LocalBackend):
    def close(self) -> None:
        if self._closed:
            raise BackendError("the backend is closed")
        super().close()


@breaks("closing-is-bounded")
class IsLongInClosing(LocalBackend):
    def close(self) -> None:
        if not self._closed:
            super().close()
            too_long()


@breaks("closing-ends-threads")
class LeavesAThread(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        threading.Thread(target=too_long, name="left").start()


@breaks("closed-backends-call-nobody")
class RunsOn(LocalBackend):
    def close(self) -> None:
        waiting = list(self.executor.ready)
        super().close()
        self.executor.ready.extend(waiting)


@breaks("closed-backends-call-nobody")
class HandsOverLate(Changed):
    def callback(self, callback: Callable[[Any], object]) -> Callable[[Any], object]:
        self.last = callback
        return callback

    def close(self) -> None:
        super().close()
        self.executor.ready.append(lambda: self.last(Vector3(1.0)))


@breaks("closed-backends-refuse")
class OpensAgain(LocalBackend):
    def close(self) -> None:
        super().close()
        self._closed = False


@breaks("closing-leaves-others-alone")
class ClosesTheWorld(LocalBackend):
    def close(self) -> None:
        super().close()
        for topic in self._bus._topics.values():
            for publisher in topic.publishers:
                publisher.close()


@breaks("ended-publishers-are-silent")
class ComplainsOfSamplesAfterClose(LocalBackend):
    def prepared_sender(self, publisher: Any, template: Any, varying: Sequence[str]) -> Sender:
        send = super().prepared_sender(publisher, template, varying)

        def send_or_complain(*sample: Any) -> None:
            if self._closed:
                raise BackendError("the backend is closed")
            send(*sample)

        return send_or_complain


@breaks("closing-gives-descriptors-back")
class LeavesADescriptor(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        LEFT_OPEN.append(os.open(os.devnull, os.O_RDONLY))
