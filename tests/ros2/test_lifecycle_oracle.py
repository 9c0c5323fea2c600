"""rclpy's own lifecycle node as the oracle of ours. Both are asked directly, not over a network.

Where rclpy is wrong and we differ on purpose is the data below.
"""

from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lifecycle_msgs import msg, srv
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode as RclpyNode
from rclpy.lifecycle import TransitionCallbackReturn

from rosbase.contracts.backend import BackendOptions
from rosbase.errors import TransitionNotAvailableError
from rosbase.lifecycle import CALLBACKS, CallbackReturn
from rosbase.local import Bus, LocalBackend
from rosbase.roles.lifecycle_node import LifecycleNode
from support.ros import ros_context
from support.strategies import answers, labels

DIFFERENCES = {
    "an id that is not available": "raises out of rclpy's service; with us success is false",
    "an answer that is no CallbackReturn": "leaves rclpy in the transition state for good, no "
    "request works any more; with us it is ERROR",
}

RAISES = ValueError("raised by the callback")
REQUESTS = st.tuples(
    st.sampled_from([0, 1, 2, 3, 4, 5, 6, 7, 8]) | st.integers(0, 255), st.just("") | labels
)
ANSWERS = answers | st.just(RAISES)
# A walk of random requests seldom gets far; most of these are good somewhere.
STEPS = st.lists(st.tuples(REQUESTS, ANSWERS, ANSWERS), max_size=20)


def answer(value: Any) -> Any:
    if isinstance(value, BaseException):
        raise value
    return value


class Ours(LifecycleNode):
    answer: Any = CallbackReturn.SUCCESS
    error_answer: Any = CallbackReturn.SUCCESS

    def request(self, transition_id: int, label: str) -> bool:
        try:
            return self.request_transition(transition_id, label) is CallbackReturn.SUCCESS
        except TransitionNotAvailableError:
            return False

    def available(self) -> list[tuple[int, str]]:
        return [(t.id, t.label) for t in self.get_available_transitions()]


class Theirs(RclpyNode):  # type: ignore[misc]  # rclpy is Any to mypy
    answer: Any = CallbackReturn.SUCCESS
    error_answer: Any = CallbackReturn.SUCCESS

    def start_over(self) -> None:
        # A new node takes 60 ms; a new machine for the same node takes none.
        machine = rclpy_implementation.LifecycleStateMachine(self.handle, False)
        self._state_machine: Any = machine

    def request(self, transition_id: int, label: str) -> bool:
        wanted = srv.ChangeState.Request(transition=msg.Transition(id=transition_id, label=label))
        service: Any = self._LifecycleNodeMixin__on_change_state
        try:
            return bool(service(wanted, srv.ChangeState.Response()).success)
        except rclpy_implementation.RCLError:
            # DIFFERENCES: "an id that is not available".
            assert not label
            return False

    def state(self) -> tuple[int, str]:
        state_id, label = self._state_machine.current_state
        return state_id, label

    def available(self) -> list[tuple[int, str]]:
        return [(t[0], t[1]) for t in self._state_machine.available_transitions]


def ours_answers(name: str) -> Any:
    field = "error_answer" if name == "on_error" else "answer"
    return lambda self, previous: answer(getattr(self, field))


def theirs_answers(name: str) -> Any:
    ours = ours_answers(name)

    def callback(self: Any, previous: Any) -> Any:
        value = ours(self, previous)
        return getattr(TransitionCallbackReturn, value.name) if value is not None else None

    return callback


for _name in CALLBACKS.values():
    setattr(Ours, _name, ours_answers(_name))
    setattr(Theirs, _name, theirs_answers(_name))


@pytest.fixture(scope="module")
def theirs(warm_ros: None) -> Iterator[Theirs]:
    with ros_context() as context:
        node: Any = Theirs("oracle", context=context, enable_communication_interface=False)
        yield node
        node.destroy_node()


def make() -> Ours:
    return Ours(backend=LocalBackend(BackendOptions("ours"), Bus()))


@given(steps=STEPS)
def test_requests_and_answers_lead_where_rclpy_goes(theirs: Theirs, steps: list[Any]) -> None:
    ours = make()
    theirs.start_over()
    for request, callback_answer, error_answer in steps:
        for node in (ours, theirs):
            node.answer, node.error_answer = callback_answer, error_answer
        assert ours.request(*request) == theirs.request(*request)
        assert (ours.get_state().id, ours.get_state().label) == theirs.state()
        assert ours.available() == theirs.available()
    ours.destroy_node()


def test_rclpy_raises_where_we_refuse(theirs: Theirs) -> None:
    theirs.start_over()
    with pytest.raises(rclpy_implementation.RCLError):
        theirs.trigger_activate()
    assert not make().request(3, "")


def test_a_callback_that_forgets_to_answer_is_stuck_in_rclpy_and_an_error_with_us(
    theirs: Theirs,
) -> None:
    theirs.start_over()
    ours = make()
    ours.answer = theirs.answer = None
    with pytest.raises(AttributeError):
        theirs.request(1, "")
    assert theirs.state()[1] == "configuring"
    assert not ours.request(1, "")
    assert ours.get_state().label == "unconfigured"
