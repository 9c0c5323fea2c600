"""What is wrong with topics."""

import copy
from collections.abc import Callable, Sequence
from typing import Any

from attrs import evolve

from rosbase.contracts.backend import BackendOptions, Publisher
from rosbase.contracts.node_connection import Sender
from rosbase.errors import BackendError
from rosbase.local import Bus, LocalBackend
from rosbase.messages import Imu
from support.backend_mutants.changed import Changed, breaks


@breaks("every-subscription-hears")
class SaysEverythingTwice(Changed):
    def send(self, publisher: Publisher[Any], message: Any) -> None:
        publisher.publish(message)
        publisher.publish(message)


@breaks("messages-arrive-equal")
class ForgetsCovariances(Changed):
    def callback(self, callback: Callable[[Any], object]) -> Callable[[Any], object]:
        return lambda message: callback(
            evolve(message, orientation_covariance=(0.0,) * 9)
            if isinstance(message, Imu)
            else message
        )


@breaks("names-are-full")
class ShortensNames(Changed):
    def create_publisher(self, msg_type: Any, topic: Any, qos_profile: Any) -> Any:
        publisher: Any = super().create_publisher(msg_type, topic, qos_profile)
        publisher.topic = topic
        return publisher


@breaks("wrong-names-are-errors")
class MakesNamesUp(Changed):
    def name(self, topic: str) -> str:
        return "".join(filter(str.isascii, str(topic))).strip("/") or "nameless"


@breaks("wrong-names-are-errors")
class SaysNotWhichNameIsWrong(LocalBackend):
    def create_publisher(self, msg_type: Any, topic: Any, qos_profile: Any) -> Publisher[Any]:
        try:
            return super().create_publisher(msg_type, topic, qos_profile)
        except BackendError:
            raise BackendError("a wrong name") from None


@breaks("wrong-types-are-errors")
@breaks("wrong-messages-are-errors")
class TakesAnything(Changed):
    def msg_type(self, msg_type: type) -> type:
        return object


@breaks("wrong-messages-are-errors")
class SendsWhatItRefuses(Changed):
    def send(self, publisher: Any, message: Any) -> None:
        try:
            publisher.publish(message)
        except TypeError:
            for deliver in publisher._deliveries:
                deliver(message)
            raise


@breaks("wrong-messages-are-errors")
class TakesAnyTemplate(LocalBackend):
    def prepared_sender(
        self, publisher: Publisher[Any], template: Any, varying: Sequence[str]
    ) -> Sender:
        return lambda *values: None


@breaks("samples-arrive-like-messages")
class ForgetsTheTemplate(LocalBackend):
    def prepared_sender(
        self, publisher: Publisher[Any], template: Any, varying: Sequence[str]
    ) -> Sender:
        return super().prepared_sender(publisher, type(template)(), varying)


@breaks("delivers-in-process")
class Copies(Changed):
    def callback(self, callback: Callable[[Any], object]) -> Callable[[Any], object]:
        return lambda message: callback(copy.copy(message))


@breaks("delivers-in-process")
class DeliversLater(Changed):
    def send(self, publisher: Publisher[Any], message: Any) -> None:
        self.call_soon(lambda: publisher.publish(message))


@breaks("delivers-in-process")
class SaysNotThatItDelivers(LocalBackend):
    delivers_in_process = False


@breaks("backends-hear-each-other")
class LivesInAWorldOfItsOwn(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options, Bus())
