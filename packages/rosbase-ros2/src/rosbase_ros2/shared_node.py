"""The rclpy node of a backend, which rosbase and the program share.

What rosbase creates on it is marked by its callback group, an `OwnGroup`, and served by rosbase's
thread. Everything else is the program's: it is served by threads of its own (`native`), whatever
it takes. No other executor serves either of them. So an executor of the program's that spins the
node finds nothing here to take away, and need not give anything back.
"""

import copy
from collections.abc import Callable, Iterator
from typing import Any

from rclpy.callback_groups import CallbackGroup, ReentrantCallbackGroup
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.service import Service
from rclpy.time_source import TimeSource

from rosbase_ros2.answers import Answers
from rosbase_ros2.hanging import end_if_hanging
from rosbase_ros2.node_logger import LogListener, NodeLogger
from rosbase_ros2.qos_warnings import warn_of_publishers, warn_of_subscriptions

__all__ = ["EntityView", "OwnGroup", "ServiceGroup", "SharedNode"]

_LOG_S = 1.0


class OwnGroup(ReentrantCallbackGroup):  # type: ignore[misc]  # rclpy is Any
    """Callback group of what rosbase creates on its rclpy node."""


class ServiceGroup(OwnGroup):
    """Callback group of services whose answers are sent again if the middleware drops them."""

    def __init__(self, warn: Callable[[str], object]) -> None:
        """Take a function that is called with a line for each answer that was not sent."""
        super().__init__()
        self._warn = warn

    def add_entity(self, entity: Any) -> None:
        """Take an entity; a service has not been seen by an executor yet."""
        super().add_entity(entity)
        if isinstance(entity, Service):
            answers = Answers(entity.send_response, entity.service_name, self._warn)
            entity.send_response = answers.send


class EntityView:
    """The part of a node that one executor serves, with the attributes that executors read."""

    def __init__(self, node: "SharedNode", *, is_own: bool) -> None:
        """Show what rosbase has created on the node, or what the program has."""
        self.executor: Any = None
        """Executor that serves it; rclpy sets it."""
        self._node = node
        self._is_own = is_own
        # An executor reads them twice for each message, and they seldom change.
        self._found: dict[str, tuple[Any, ...]] = {}

    @property
    def subscriptions(self) -> Iterator[Any]:
        """Subscriptions of this view."""
        return self._select("subscriptions")

    @property
    def timers(self) -> Iterator[Any]:
        """Timers of this view."""
        return self._select("timers")

    @property
    def clients(self) -> Iterator[Any]:
        """Clients of this view."""
        return self._select("clients")

    @property
    def services(self) -> Iterator[Any]:
        """Services of this view."""
        return self._select("services")

    @property
    def guards(self) -> Iterator[Any]:
        """Guard conditions of this view."""
        return self._select("guards")

    @property
    def waitables(self) -> Iterator[Any]:
        """Everything else that can be waited for: actions, and events of the middleware."""
        return self._select("waitables")

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to serve."""
        kinds = ("subscriptions", "timers", "clients", "services", "guards", "waitables")
        return not any(tuple(self._select(kind)) for kind in kinds)

    def refresh(self) -> None:
        """Look at the node again: something was created or destroyed."""
        self._found = {}

    def _select(self, kind: str) -> Iterator[Any]:
        # Another thread may refresh it meanwhile; then this is from before, and not kept.
        cache = self._found
        found = cache.get(kind)
        if found is None:
            found = cache[kind] = tuple(
                entity
                for entity in self._node.entities(kind)
                if isinstance(entity.callback_group, OwnGroup) is self._is_own
            )
        return iter(found)


class SharedNode(Node):  # type: ignore[misc]  # rclpy is Any
    """A node of rclpy with two sides: rosbase's own and the program's."""

    # For the base class, whose constructor asks for them.
    native_executor: Any = None
    """Executor of the program's side, once there is one."""
    _node_logger: NodeLogger | None = None
    _own_group: CallbackGroup | None = None
    publisher_listener: Callable[[Any], object] | None = None
    native_listener: Callable[[], object] | None = None

    def __init__(self, name: str, **options: Any) -> None:
        """Create the node. It publishes no `/rosout`; for that there are `log_listeners`.

        Args:
            name: Name of the node.
            options: As for rclpy's node.
        """
        self.own = EntityView(self, is_own=True)
        """Everything that rosbase has created, with the services of rclpy itself."""
        self.native = EntityView(self, is_own=False)
        """Everything that the program has created."""
        self.log_listeners: list[LogListener] = []
        """Called with each record of the node's logger."""
        self.publisher_listener = None
        """Called with each publisher of rclpy that is created from now on."""
        self.native_listener = None
        """Called when the program itself uses the node for something that publishes or waits."""
        # For the services of rclpy itself, such as those of parameters.
        self._own_group = ServiceGroup(self._warn)
        super().__init__(name, enable_rosout=False, **options)
        self._own_group = None

    def entities(self, kind: str) -> Iterator[Any]:
        """Return everything of a kind, such as `subscriptions`, that was created on the node."""
        found: Iterator[Any] = getattr(super(), kind)
        return found

    # What an executor of the program's finds.

    subscriptions = timers = clients = services = guards = waitables = property(lambda self: ())

    @property
    def executor(self) -> Any:
        """Executor of the program's side, on threads of its own; None while there is none."""
        return self.native_executor

    @executor.setter
    def executor(self, executor: Any) -> None:
        # An executor of the program's sets it, in its `add_node`.
        if self.native_executor is not None and executor is not None:
            self.native_executor.welcome(executor)

    @property
    def default_callback_group(self) -> Any:
        """Callback group of the program's side."""
        return self._own_group or super().default_callback_group

    def create_publisher(
        self,
        msg_type: Any,
        topic: str,
        qos_profile: Any,
        *,
        event_callbacks: Any = None,
        **options: Any,
    ) -> Any:
        """Create a publisher of rclpy."""
        # A copy: the program may use its object for several topics.
        events = copy.copy(event_callbacks) or PublisherEventCallbacks()
        warn_of_subscriptions(events, topic, self.get_logger)
        publisher = super().create_publisher(
            msg_type, topic, qos_profile, event_callbacks=events, **options
        )
        if self.publisher_listener is not None:
            self.publisher_listener(publisher)
            if not isinstance(options.get("callback_group"), OwnGroup):
                self.note_native()
        return publisher

    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[..., object],
        qos_profile: Any,
        *,
        callback_group: Any = None,
        event_callbacks: Any = None,
        **options: Any,
    ) -> Any:
        """Create a subscription of rclpy."""
        events = copy.copy(event_callbacks) or SubscriptionEventCallbacks()
        warn_of_publishers(events, topic, self.get_logger)
        if isinstance(getattr(callback, "__self__", None), TimeSource):
            # `/clock` moves the timers of rosbase. rclpy subscribes to it when it is wanted.
            callback_group = OwnGroup()
        return super().create_subscription(
            msg_type,
            topic,
            callback,
            qos_profile,
            callback_group=callback_group,
            event_callbacks=events,
            **options,
        )

    def destroy_node(self) -> None:
        """Destroy the node; end the process if DDS hangs, as it may with the last node."""
        kinds = ("publishers", "subscriptions", "clients", "services", "timers", "guards")
        count = sum(1 for kind in kinds for _ in self.entities(kind))
        with end_if_hanging(count):
            super().destroy_node()

    def note_native(self) -> None:
        """Note that the program itself uses the node."""
        if self.native_listener is not None:
            self.native_listener()

    def _warn(self, what: str) -> None:
        self.get_logger().warning(what, throttle_duration_sec=_LOG_S)

    def get_logger(self) -> Any:
        """Return the logger of the node."""
        if self._node_logger is None:
            self._node_logger = NodeLogger(super().get_logger().name, self.log_listeners)
        return self._node_logger
