"""The interface of a node's lifecycle for the ROS tools: five services and one topic.

Names, types and order follow rcl_lifecycle's `com_interface.c`. rclpy's own lifecycle node
is not used: it has its own machine, whose callbacks run on the executor's thread.

Two threads meet here. The executor of rclpy answers on its own; transitions run on the main loop.
So `change_state` hands the request over and awaits the answer. Meanwhile the executor is free to
report the state of the transition.
"""

import threading
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from lifecycle_msgs import msg, srv
from rclpy.node import Node
from rclpy.task import Future

from rosbase import Clock, ManagedNode, RosbaseLogger, State, TransitionEvent
from rosbase.contracts.recorded_answers import change_state
from rosbase.lifecycle import TRANSITIONS, Transition
from rosbase_ros2.clock import RosClock
from rosbase_ros2.refusals import RCLError, Refusals
from rosbase_ros2.shared_node import OwnGroup, ServiceGroup

__all__ = ["LifecycleServices"]

_EVENT_DEPTH = 10
_LOG_S = 1.0


class LifecycleServices:
    """Lets `ros2 lifecycle`, launch files and nav2 see and change a node's lifecycle.

    Its services and topic are destroyed with the rclpy node. The executor must have stopped by
    then. It may not be rclpy's EventsExecutor, which cannot await the callback of a service
    (7.1.6).
    """

    def __init__(
        self,
        node: Node,
        managed: ManagedNode,
        call_soon: Callable[[Callable[[], object]], object],
        logger: RosbaseLogger,
    ) -> None:
        """Create the services and the topic of transitions.

        Args:
            node: The rclpy node under whose name they appear.
            managed: The node with the lifecycle.
            call_soon: Queues a function for the main loop, also while that waits for an answer of a
                service. It is called on the thread of the
                executor that spins `node`.
            logger: Logs requests that fail.
        """
        # rclpy says that it is typed, but most of its functions are not.
        self._node: Any = node
        self._managed = managed
        self._call_soon = call_soon
        self._logger = logger
        self._clock: Clock = RosClock(node)
        self._refusals = Refusals(self._node.context, logger)
        # Requests that the main loop has not begun; guarded with _closed by the lock.
        self._waiting: set[Any] = set()
        self._closed = False
        self._lock = threading.Lock()
        self._create_services()
        self._events = node.create_publisher(
            msg.TransitionEvent, "~/transition_event", _EVENT_DEPTH, callback_group=OwnGroup()
        )
        managed.add_transition_listener(self._publish)

    def close(self) -> None:
        """Refuse pending and later requests. Call it from any thread.

        Call it when the main loop has ended, because nobody would answer them. Call it
        before the executor stops, which sends the answers. Events are published until the
        node is destroyed.
        """
        with self._lock:
            self._closed = True
            refused, self._waiting = self._waiting, set()
        for answer in refused:
            _settle(answer, success=False)

    def _create_services(self) -> None:
        # A reentrant one: else no other service would be answered while change_state waits.
        group = ServiceGroup(self._warn)
        callbacks = (
            ("change_state", srv.ChangeState, self._change_state),
            ("get_state", srv.GetState, self._get_state),
            ("get_available_states", srv.GetAvailableStates, self._get_available_states),
            ("get_available_transitions", srv.GetAvailableTransitions, self._get_available),
            ("get_transition_graph", srv.GetAvailableTransitions, self._get_graph),
        )
        for name, kind, callback in callbacks:
            self._node.create_service(kind, f"~/{name}", callback, callback_group=group)

    # What the services answer, on the executor's thread. An exception here would end the
    # executor of everything, so none leaves.

    async def _change_state(self, request: Any, response: Any) -> Any:
        try:
            response.success = await self._hand_over(request.transition)
        except Exception as error:
            self._log_error("change_state", error)
            response.success = False
        return response

    def _get_state(self, request: Any, response: Any) -> Any:
        try:
            response.current_state = _state(self._managed.get_state())
        except Exception as error:
            self._log_error("get_state", error)
        return response

    def _get_available_states(self, request: Any, response: Any) -> Any:
        response.available_states = [_state(state) for state in State]
        return response

    def _get_available(self, request: Any, response: Any) -> Any:
        try:
            available = self._managed.get_available_transitions()
            response.available_transitions = _descriptions(available)
        except Exception as error:
            self._log_error("get_available_transitions", error)
        return response

    def _get_graph(self, request: Any, response: Any) -> Any:
        response.available_transitions = _descriptions(TRANSITIONS)
        return response

    # The way of a request over to the main loop and back.

    def _hand_over(self, wanted: Any) -> Any:
        """Queue a transition for the main loop; return the future of its success."""
        answer: Any = Future()
        # Otherwise the executor would not notice that what awaits it can go on.
        answer.add_done_callback(lambda _: self._node.executor.wake())
        with self._lock:
            # Not queued: by the time its turn came, the state would be another one.
            busy = self._managed.describe_transition() or ("busy" if self._waiting else "")
            if not (self._closed or busy):
                self._waiting.add(answer)
        if self._closed or busy:
            _settle(answer, success=False)
            if busy:
                self._logger.warning(f"change_state refused: {busy}")
            return answer
        try:
            self._queue(
                wanted.id, wanted.label, partial(self._run, answer, wanted.id, wanted.label)
            )
        except Exception:
            with self._lock:
                self._waiting.discard(answer)
            raise
        return answer

    def _queue(self, transition_id: int, label: str, run: Callable[[], object]) -> None:
        self._call_soon(run)

    def _run(self, answer: Any, transition_id: int, label: str) -> None:
        """Run a transition, on the main loop, unless the request has been refused meanwhile."""
        with self._lock:
            if answer not in self._waiting:
                return
            self._waiting.remove(answer)
        success = False
        try:
            success = change_state(self._managed, transition_id, label, self._logger)
        finally:
            # What ends the program goes on to the main loop; the client has its answer first.
            _settle(answer, success=success)

    def _publish(self, event: TransitionEvent) -> None:
        """Publish one step. Called on the thread that takes it."""
        message = msg.TransitionEvent(
            # Without a sign, so a date before 1970 cannot be sent.
            timestamp=max(0, self._clock.now_ns()),
            transition=_transition(event.transition),
            start_state=_state(event.start),
            goal_state=_state(event.goal),
        )
        self._send(message)

    def _send(self, message: Any) -> None:
        try:
            self._events.publish(message)
        except RCLError as error:
            self._refusals.judge("~/transition_event", error)

    def _warn(self, what: str) -> None:
        self._logger.log_throttle(what, _LOG_S, "warning")

    def _log_error(self, who: str, error: Exception) -> None:
        self._logger.error(f"{who} raised {type(error).__name__}: {error}")


def _settle(answer: Any, *, success: bool) -> None:
    try:
        answer.set_result(success)
    except Exception:
        # The executor has been shut down and can no longer be woken: nobody waits.
        pass


def _state(state: State) -> Any:
    return msg.State(id=state.id, label=state.label)


def _transition(transition: Transition) -> Any:
    return msg.Transition(id=transition.id, label=transition.label)


def _descriptions(transitions: Iterable[Transition]) -> list[Any]:
    return [
        msg.TransitionDescription(
            transition=_transition(transition),
            start_state=_state(transition.start),
            goal_state=_state(transition.goal),
        )
        for transition in transitions
    ]
