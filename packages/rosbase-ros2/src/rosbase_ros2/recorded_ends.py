"""Publishers, subscriptions and services of a program that is recorded.

What other threads hand to them comes in as an entry. A replay has no ROS: it gets the bytes.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

from attrs import evolve
from rclpy.exceptions import InvalidHandle
from rclpy.serialization import serialize_message

from rosbase import Executor, RosbaseLogger, Sender, ServiceRequest
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind, Numbered
from rosbase.wire import maker
from rosbase_ros2.courier import Courier
from rosbase_ros2.formats import rewriter
from rosbase_ros2.refusals import RCLError, Refusals
from rosbase_ros2.service_courier import ServiceCourier
from rosbase_ros2.service_server import RosService
from rosbase_ros2.topics import RosPublisher, RosSubscription

__all__ = ["RecordedPublisher", "RecordedService", "RecordedSubscription"]


class RecordedPublisher(RosPublisher):
    """Sends messages; another thread's messages are entries."""

    __slots__ = ("_conductor", "_number")

    def __init__(
        self, inner: Any, courier: Courier, refusals: Refusals, conductor: Conductor
    ) -> None:
        super().__init__(inner, _in_bytes(courier), refusals)
        self._conductor = conductor
        self._number = conductor.number(Numbered.PUBLISHER, self.topic, _no_replay)

    def publish(self, message: Any) -> bool:
        """Send the message, on another thread as soon as the turn is free."""
        if self._conductor.is_inside:
            return self._judged(super().publish(message))
        self._check_class(message)
        data = self._encode(message)
        self._conductor.come_in(Kind.PUBLISH, (self._number,), data, partial(self._transmit, data))
        return True

    def prepared_sender(self, template: Any, varying: Any) -> Sender:
        """Return a sender that publishes as any other does."""
        self._check_class(template)
        return maker(template, varying, self.publish)

    @property
    def subscription_count(self) -> int:
        """Number of subscriptions that have found it."""
        count: Any = self._conductor.fact(partial(_count, self.inner))
        return int(count)

    def _transmit(self, data: Any) -> None:
        send = self._send
        if send is None:
            return
        try:
            send(data)
        except InvalidHandle:
            # Another thread may have ended it meanwhile.
            if self._send is not None:
                raise
        except RCLError as error:
            self._judged(self._refusals.judge(self.topic, error))

    def _judged(self, is_sent: bool) -> bool:
        if not is_sent:
            self._conductor.spoil(f"{self.topic}: ROS did not take a message")
        return is_sent


class RecordedSubscription(RosSubscription):
    """Last messages of a topic, each of which is an entry when it comes."""

    __slots__ = ("_conductor", "_number")

    def __init__(
        self,
        courier: Courier,
        callback: Callable[[Any], object],
        depth: int,
        schedule: Callable[[Callable[[], object]], None],
        logger: RosbaseLogger,
        conductor: Conductor,
        topic: str,
    ) -> None:
        """Number the subscription, before the first message comes.

        Args:
            courier: As for `RosSubscription`.
            callback: Likewise.
            depth: Likewise.
            schedule: Likewise.
            logger: Likewise.
            conductor: The conductor of the program.
            topic: Full name of the topic.
        """
        super().__init__(courier, callback, depth, schedule, logger)
        self._conductor = conductor
        self._number = conductor.number(Numbered.SUBSCRIPTION, topic, _no_replay)

    def deliver(self, message: Any) -> None:
        """Queue a message, as an entry."""
        data = message if isinstance(message, bytes) else bytes(serialize_message(message))
        deliver = partial(super().deliver, message)
        self._conductor.come_in(Kind.ARRIVE, (self._number,), data, deliver)

    def attach(self, inner: Any) -> None:
        """Set the rclpy subscription, which knows how many messages are kept."""
        super().attach(inner)
        self._conductor.fact(lambda: {"value": self.depth})


class RecordedService(RosService):
    """Answers requests, each of which is an entry if it comes from outside."""

    def __init__(
        self,
        name: str,
        courier: ServiceCourier,
        answer: Callable[[Any], Any],
        executor: Executor,
        logger: RosbaseLogger,
        conductor: Conductor,
    ) -> None:
        super().__init__(name, courier, answer, executor, logger)
        self._conductor = conductor
        self._number = conductor.number(Numbered.SERVICE, name, _no_replay)

    def take(self, call: ServiceRequest) -> None:
        """Queue a request. Call it from any thread."""
        if self._conductor.is_inside:
            super().take(call)
            return
        data = bytes(serialize_message(call.request))
        take = partial(super().take, call)
        self._conductor.come_in(Kind.REQUEST, (self._number,), data, take)


def _in_bytes(courier: Courier) -> Courier:
    """Return a courier that sends bytes, as a replay of the program will write them."""
    if courier.is_raw:
        return courier
    rewrite, encode = rewriter(courier.ros_type), courier.encode
    return evolve(
        courier, encode=lambda message: rewrite(bytes(serialize_message(encode(message))))
    )


def _count(inner: Any) -> int:
    try:
        count: int = inner.get_subscription_count()
    except InvalidHandle:
        # It has been destroyed.
        return 0
    return count


def _no_replay(entry: object) -> None:
    """Replay nothing: that is done without ROS."""
