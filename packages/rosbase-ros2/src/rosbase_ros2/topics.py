"""Publishers and subscriptions that convert messages."""

from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message

from rosbase import QueuedSubscription, RosbaseLogger, Sender, WireError
from rosbase.wire import maker, packer
from rosbase_ros2.courier import Courier
from rosbase_ros2.kinds import name_of
from rosbase_ros2.qos import queue_depth
from rosbase_ros2.refusals import RCLError, Refusals

__all__ = ["RosPublisher", "RosSubscription"]

# Of a publisher that keeps all.
_MOST_KEPT = 1000


class RosPublisher:
    """Sends messages of one class to one topic. Use it from any thread."""

    __slots__ = (
        "_courier",
        "_encode",
        "_kept",
        "_msg_type",
        "_refusals",
        "_send",
        "inner",
        "topic",
    )

    def __init__(self, inner: Any, courier: Courier, refusals: Refusals) -> None:
        self.inner = inner
        """Publisher of rclpy."""
        self.topic: str = inner.topic_name
        self._courier = courier
        self._msg_type, self._encode = courier.msg_type, courier.encode
        self._refusals = refusals
        self._kept = _kept(inner.qos_profile)
        self._send: Callable[[Any], object] | None = None
        self._send = self._sender()

    def publish(self, message: Any) -> bool:
        """Convert the message and send it; send nothing once the publisher has ended.

        Returns:
            False if the middleware did not take it, at a date that it cannot send.

        Raises:
            TypeError: It is not of the topic's class, or a field has a value of the wrong kind.
            ValueError: A value is out of the range of its field.
        """
        if type(message) is not self._msg_type and not isinstance(message, self._msg_type):
            raise TypeError(
                f"{self.topic} takes {name_of(self._msg_type)}, not {name_of(type(message))}"
            )
        send = self._send
        if send is not None:
            try:
                send(self._encode(message))
            except InvalidHandle:
                # Another thread may have ended it meanwhile.
                if self._send is not None:
                    raise
            except RCLError as error:
                return self._refusals.judge(self.topic, error)
        return True

    def prepared_sender(self, template: Any, varying: Sequence[str]) -> Sender:
        """Return a sender of messages like the template; see `rosbase.wire.maker`.

        It sends nothing once the publisher has ended.
        """
        if self._courier.is_raw:
            encode = packer(template, varying)
        else:
            make, encode_message = maker(template, varying), self._encode

            def encode(*values: Any) -> Any:
                return encode_message(make(*values))

        def send_values(*values: Any) -> bool:
            send = self._send
            if send is not None:
                try:
                    send(encode(*values))
                except InvalidHandle:
                    if self._send is not None:
                        raise
                except RCLError as error:
                    return self._refusals.judge(self.topic, error)
            return True

        return send_values

    @property
    def msg_type(self) -> type:
        """Class of its messages."""
        return self._msg_type

    @property
    def subscription_count(self) -> int:
        """Number of subscriptions that have found it."""
        try:
            count: int = self.inner.get_subscription_count()
        except InvalidHandle:
            # It has been destroyed.
            return 0
        return count

    def refresh(self) -> None:
        """Look again what `publish` of the rclpy publisher is; `taps` replaces it."""
        if self._send is not None:
            self._send = self._sender()

    def kept_messages(self) -> list[bytes]:
        """Return the messages that DDS keeps for late subscriptions; rclpy does not tell them."""
        return [] if self._kept is None else list(self._kept)

    def close(self) -> None:
        """Stop sending."""
        self._send = None

    def _sender(self) -> Callable[[Any], object]:
        publish, kept = self.inner.publish, self._kept
        if kept is None:
            sender: Callable[[Any], object] = publish
            return sender

        def publish_and_keep(message: Any) -> None:
            publish(message)
            # An object may be filled anew.
            data = message if isinstance(message, bytes) else bytes(serialize_message(message))
            kept.append(data)

        return publish_and_keep


def _kept(profile: QoSProfile) -> deque[bytes] | None:
    """Return room for what a latched publisher keeps."""
    if profile.durability is not DurabilityPolicy.TRANSIENT_LOCAL:
        return None
    return deque(maxlen=min(queue_depth(profile), _MOST_KEPT))


class RosSubscription(QueuedSubscription):
    """Last messages of a topic, converted when they are handled."""

    __slots__ = ("_decode", "_handle", "_logger", "inner", "msg_type")

    def __init__(
        self,
        courier: Courier,
        callback: Callable[[Any], object],
        depth: int,
        schedule: Callable[[Callable[[], object]], None],
        logger: RosbaseLogger,
    ) -> None:
        super().__init__("", self._take, depth, schedule)
        self._decode, self._handle = courier.decode, callback
        self.msg_type = courier.msg_type
        """Class of its messages."""
        self._logger = logger
        self.inner: Any = None
        """Subscription of rclpy."""

    def _take(self, received: Any) -> None:
        try:
            message = self._decode(received)
        except WireError as error:
            # rclpy drops such a message too.
            self._logger.log_throttle(f"{self.topic}: dropped a message: {error}", 1.0, "warning")
            return
        self._handle(message)

    def attach(self, inner: Any) -> None:
        """Set the rclpy subscription that delivers here; its profile may have been overridden."""
        self.inner = inner
        self.topic = inner.topic_name
        self.resize(queue_depth(inner.qos_profile))
