"""How a lifecycle node answers its standard services, as rcl_lifecycle does.

Imported when the first request comes.
"""

from collections.abc import Callable, Iterable
from functools import partial

from rosbase.errors import TransitionNotAvailableError
from rosbase.lifecycle import (
    TRANSITIONS,
    CallbackReturn,
    ManagedNode,
    State,
    Transition,
    TransitionEvent,
)
from rosbase.local.standard.node_services import Answers
from rosbase.messages import lifecycle_msgs as msgs

__all__ = ["event_message", "lifecycle_answers"]


def lifecycle_answers(node: ManagedNode, warn: Callable[[str], object]) -> Answers:
    """Return the answers of a lifecycle node.

    Args:
        node: The node.
        warn: Called with a line for each request that is refused.
    """
    return {
        "change_state": (msgs.ChangeState, partial(_change_state, node, warn)),
        "get_state": (msgs.GetState, partial(_get_state, node)),
        "get_available_states": (msgs.GetAvailableStates, _get_available_states),
        "get_available_transitions": (msgs.GetAvailableTransitions, partial(_get_available, node)),
        "get_transition_graph": (msgs.GetAvailableTransitions, _get_graph),
    }


def event_message(event: TransitionEvent, now_ns: int) -> msgs.TransitionEvent:
    """Return the message of one step of a node.

    Args:
        event: The step.
        now_ns: The date in nanoseconds. ROS has none before 1970.
    """
    return msgs.TransitionEvent(
        timestamp=max(0, now_ns),
        transition=_transition(event.transition),
        start_state=_state(event.start),
        goal_state=_state(event.goal),
    )


def _change_state(
    node: ManagedNode, warn: Callable[[str], object], request: msgs.ChangeState_Request
) -> msgs.ChangeState_Response:
    wanted = request.transition
    try:
        result = node.request_transition(wanted.id, wanted.label)
    except TransitionNotAvailableError as error:
        warn(f"change_state refused: {error}")
        return msgs.ChangeState_Response(success=False)
    return msgs.ChangeState_Response(success=result is CallbackReturn.SUCCESS)


def _get_state(node: ManagedNode, _: msgs.GetState_Request) -> msgs.GetState_Response:
    return msgs.GetState_Response(current_state=_state(node.get_state()))


def _get_available_states(_: msgs.GetAvailableStates_Request) -> msgs.GetAvailableStates_Response:
    return msgs.GetAvailableStates_Response(available_states=tuple(map(_state, State)))


def _get_available(
    node: ManagedNode, _: msgs.GetAvailableTransitions_Request
) -> msgs.GetAvailableTransitions_Response:
    return _descriptions(node.get_available_transitions())


def _get_graph(
    _: msgs.GetAvailableTransitions_Request,
) -> msgs.GetAvailableTransitions_Response:
    return _descriptions(TRANSITIONS)


def _descriptions(transitions: Iterable[Transition]) -> msgs.GetAvailableTransitions_Response:
    return msgs.GetAvailableTransitions_Response(
        available_transitions=tuple(
            msgs.TransitionDescription(
                transition=_transition(transition),
                start_state=_state(transition.start),
                goal_state=_state(transition.goal),
            )
            for transition in transitions
        )
    )


def _state(state: State) -> msgs.State:
    return msgs.State(id=state.id, label=state.label)


def _transition(transition: Transition) -> msgs.Transition:
    return msgs.Transition(id=transition.id, label=transition.label)
