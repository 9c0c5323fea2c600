"""The services of a lifecycle whose program is recorded: requests are entries."""

from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.serialization import serialize_message

from rosbase import Clock, ManagedNode, RosbaseLogger
from rosbase.contracts.recorded_answers import found
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind, Numbered
from rosbase.entries.payloads import to_json
from rosbase.messages import lifecycle_msgs
from rosbase.wire import reader, writer
from rosbase_ros2.lifecycle_services import LifecycleServices

__all__ = ["RecordedLifecycleServices"]


class RecordedLifecycleServices(LifecycleServices):
    """Lets the tools drive a node, and publishes its transitions as a replay does."""

    def __init__(
        self,
        node: Any,
        managed: ManagedNode,
        call_soon: Callable[[Callable[[], object]], object],
        logger: RosbaseLogger,
        conductor: Conductor,
        clock: Clock,
    ) -> None:
        """Number the node, and create the services.

        Args:
            node: As for `LifecycleServices`.
            managed: Likewise.
            call_soon: Likewise.
            logger: Likewise.
            conductor: The conductor of the program.
            clock: The clock of the node, whose readings are recorded.
        """
        self._conductor = conductor
        self._read: Callable[[bytes], Any] = reader(lifecycle_msgs.TransitionEvent)
        self._write: Callable[[Any], bytes] = writer(lifecycle_msgs.TransitionEvent)
        topic = found(conductor, lambda: str(node.resolve_topic_name("~/transition_event")))
        self._number = conductor.number(Numbered.SERVICE, topic, str)
        super().__init__(node, managed, call_soon, logger)
        self._clock = clock

    def _queue(self, transition_id: int, label: str, run: Callable[[], object]) -> None:
        asked = to_json({"id": transition_id, "label": label})
        queue = partial(super()._queue, transition_id, label, run)
        self._conductor.come_in(Kind.REQUEST, (self._number,), asked, queue)

    def _send(self, message: Any) -> None:
        # rclpy's own bytes have anything in their gaps.
        super()._send(self._write(self._read(bytes(serialize_message(message)))))
