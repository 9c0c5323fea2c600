"""The services of a lifecycle whose program is recorded: requests are entries."""

from collections.abc import Callable
from functools import partial
from typing import Any

from rosbase import ManagedNode, RosbaseLogger, TransitionEvent
from rosbase.contracts.recorded_answers import found
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind, Numbered
from rosbase.entries.payloads import to_json
from rosbase.local.standard.lifecycle_answers import event_message
from rosbase.messages import lifecycle_msgs
from rosbase.wire import writer
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
        now_ns: Callable[[], int],
    ) -> None:
        """Number the node, and create the services.

        Args:
            node: As for `LifecycleServices`.
            managed: Likewise.
            call_soon: Likewise.
            logger: Likewise.
            conductor: The conductor of the program.
            now_ns: The clock of the node, whose readings are recorded.
        """
        self._conductor, self._now_ns = conductor, now_ns
        self._write: Callable[[Any], bytes] = writer(lifecycle_msgs.TransitionEvent)
        topic = found(conductor, lambda: str(node.resolve_topic_name("~/transition_event")))
        self._number = conductor.number(Numbered.SERVICE, topic, str)
        super().__init__(node, managed, call_soon, logger)

    def _queue(self, transition_id: int, label: str, run: Callable[[], object]) -> None:
        asked = to_json({"id": transition_id, "label": label})
        queue = partial(super()._queue, transition_id, label, run)
        self._conductor.come_in(Kind.REQUEST, (self._number,), asked, queue)

    def _publish(self, event: TransitionEvent) -> None:
        # rclpy's own bytes have anything in their gaps.
        self._send(self._write(event_message(event, self._now_ns())))
