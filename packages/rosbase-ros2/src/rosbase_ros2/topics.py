"""Publishers and subscriptions that convert messages."""

from collections.abc import Callable
from typing import Any

from rclpy.exceptions import InvalidHandle

from rosbase import ImuSender, QueuedSubscription
from rosbase.messages import Imu, MagneticField
from rosbase_ros2.cdr import ImuEncoder, MagneticFieldEncoder, sample_packer
from rosbase_ros2.conversion import Converter
from rosbase_ros2.kinds import name_of
from rosbase_ros2.qos import queue_depth
from rosbase_ros2.refusals import RCLError, Refusals

__all__ = ["RosPublisher", "RosSubscription"]


# rclpy publishes bytes as they are: what comes at a high rate is not built as a message first.
_ENCODERS: dict[type, Callable[[], Callable[[Any], bytes]]] = {
    Imu: lambda: ImuEncoder().encode,
    MagneticField: lambda: MagneticFieldEncoder().encode,
}


class RosPublisher:
    """Sends messages of one class to one topic. Use it from any thread."""

    __slots__ = ("_msg_type", "_refusals", "_send", "_to_ros", "inner", "topic")

    def __init__(self, inner: Any, converter: Converter, refusals: Refusals) -> None:
        self.inner = inner
        """Publisher of rclpy."""
        self.topic: str = inner.topic_name
        self._msg_type = converter.msg_type
        encoder = _ENCODERS.get(converter.msg_type)
        self._to_ros = encoder() if encoder else converter.to_ros
        self._refusals = refusals
        self._send: Callable[[Any], object] | None = inner.publish

    def publish(self, message: Any) -> bool:
        """Convert the message and send it; send nothing once the publisher has ended.

        Returns:
            False if the middleware did not take it, at a date that it cannot send.

        Raises:
            TypeError: It is not of the topic's class, or a field has a value of the wrong kind.
            ValueError: A value is out of the range of its field.
        """
        if type(message) is not self._msg_type:
            raise TypeError(
                f"{self.topic} takes {name_of(self._msg_type)}, not {name_of(type(message))}"
            )
        send = self._send
        if send is not None:
            try:
                send(self._to_ros(message))
            except InvalidHandle:
                # Another thread may have ended it meanwhile.
                if self._send is not None:
                    raise
            except RCLError as error:
                return self._refusals.judge(self.topic, error)
        return True

    def imu_sender(self, template: Imu) -> ImuSender:
        """Return a sender of samples like the template.

        It sends nothing once the publisher has ended.
        """
        pack = sample_packer(template)

        def send_sample(*sample: Any) -> bool:
            send = self._send
            if send is not None:
                try:
                    send(pack(*sample))
                except InvalidHandle:
                    if self._send is not None:
                        raise
                except RCLError as error:
                    return self._refusals.judge(self.topic, error)
            return True

        return send_sample

    def close(self) -> None:
        """Stop sending."""
        self._send = None


class RosSubscription(QueuedSubscription):
    """Last messages of a topic, converted when they are handled."""

    __slots__ = ("inner",)

    def __init__(
        self,
        converter: Converter,
        callback: Callable[[Any], object],
        depth: int,
        schedule: Callable[[Callable[[], object]], None],
    ) -> None:
        from_ros = converter.from_ros
        super().__init__("", lambda message: callback(from_ros(message)), depth, schedule)
        self.inner: Any = None
        """Subscription of rclpy."""

    def attach(self, inner: Any) -> None:
        """Set the rclpy subscription that delivers here; its profile may have been overridden."""
        self.inner = inner
        self.topic = inner.topic_name
        self.resize(queue_depth(inner.qos_profile))
