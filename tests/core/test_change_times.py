"""Parameters of a lifecycle node that may change only in some states."""

import threading
from typing import Any

import pytest

from rosbase import (
    BaseNode,
    CallbackReturn,
    LifecycleNode,
    Parameter,
    ParameterError,
    ParameterSpec,
    SetParametersResult,
    State,
)
from rosbase.testing import virtual_backend

SPECS = (
    ParameterSpec("gain", 1.0),
    ParameterSpec("topic", "a", change_time="inactive"),
    ParameterSpec("device", "x", change_time="unconfigured"),
)
CHANGES: dict[str, Any] = {"gain": 2.0, "topic": "b", "device": "y"}
NEXT = "cannot be set while {}: set it while unconfigured"
NOT_ACTIVE = "cannot be set while active: set it while inactive or unconfigured"
NEVER = "cannot be set any more: the node is finalized"
REFUSED = {
    State.UNCONFIGURED: {},
    State.INACTIVE: {"device": NEXT},
    State.ACTIVE: {"topic": NOT_ACTIVE, "device": NEXT},
    State.FINALIZED: {"topic": NEVER, "device": NEVER},
}


class Node(LifecycleNode):
    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.asked: list[str] = []
        self.gate, self.entered = threading.Event(), threading.Event()
        self.gate.set()
        self.add_on_set_parameters_callback(self.judge)
        for spec in SPECS:
            self.declare_parameter(spec.name, spec.default, spec)

    def judge(self, parameters: list[Parameter[Any]]) -> SetParametersResult:
        self.asked += [parameter.name for parameter in parameters]
        return SetParametersResult(successful=True)

    def on_configure(self, previous_state: State) -> CallbackReturn:
        self.entered.set()
        self.gate.wait(10)
        return CallbackReturn.SUCCESS


def node_in(state: State) -> Node:
    node = Node(backend=virtual_backend())
    if state in (State.INACTIVE, State.ACTIVE):
        node.trigger_configure()
    if state is State.ACTIVE:
        node.trigger_activate()
    if state is State.FINALIZED:
        node.trigger_shutdown()
    assert node.get_state() is state
    return node


@pytest.mark.parametrize("name", CHANGES)
@pytest.mark.parametrize("state", REFUSED)
def test_a_change_is_taken_or_refused_with_the_state_in_which_it_would_count(
    state: State, name: str
) -> None:
    node = node_in(state)
    reason = REFUSED[state].get(name, "").format(state.name.lower())
    result = node.set_parameter(name, CHANGES[name])
    assert (result.successful, result.reason) == (
        not reason,
        reason and f"parameter {name} {reason}",
    )
    before = {spec.name: spec.default for spec in SPECS}[name]
    assert node.get_parameter(name).value == (before if reason else CHANGES[name])
    # A callback that would apply it is not even asked.
    assert node.asked == ([] if reason else [name])
    node.destroy_node()


@pytest.mark.parametrize("state", REFUSED)
def test_the_value_that_a_parameter_has_is_never_refused(state: State) -> None:
    node = node_in(state)
    values = [Parameter(spec.name, spec.default) for spec in SPECS]
    assert node.set_parameters(values).successful
    node.destroy_node()


def test_of_several_parameters_none_is_set_if_one_may_not_change() -> None:
    node = node_in(State.ACTIVE)
    result = node.set_parameters([Parameter("gain", 3.0), Parameter("device", "z")])
    assert result.reason == f"parameter device {NEXT}".format(node.get_state().name.lower())
    assert node.get_parameter("gain").value == 1.0
    node.destroy_node()


def test_while_a_transition_runs_only_what_may_always_change_does() -> None:
    node = node_in(State.UNCONFIGURED)
    node.gate.clear()
    thread = threading.Thread(target=node.trigger_configure)
    thread.start()
    assert node.entered.wait(10)
    assert node.set_parameter("device", "y").reason == "busy: configuring since 0 s"
    assert node.set_parameter("gain", 5.0).successful
    node.gate.set()
    thread.join()
    node.destroy_node()


def test_without_a_callback_of_the_program_it_is_refused_too() -> None:
    node = LifecycleNode(backend=virtual_backend())
    node.declare_parameter("device", "x", SPECS[2])
    node.trigger_configure()
    assert node.set_parameter("device", "y").reason == f"parameter device {NEXT}".format(
        node.get_state().name.lower()
    )
    node.destroy_node()


def test_the_limit_is_of_the_name_that_is_declared() -> None:
    node = LifecycleNode(backend=virtual_backend())
    node.declare_parameter("port", "x", SPECS[2])
    node.trigger_configure()
    assert node.set_parameter("port", "y").reason.startswith("parameter port cannot be set")
    node.destroy_node()


def test_a_node_without_a_lifecycle_cannot_limit_when_a_parameter_changes() -> None:
    node = BaseNode(backend=virtual_backend())
    said = "^parameter device has change_time 'unconfigured', which only a lifecycle node can have$"
    with pytest.raises(ParameterError, match=said):
        node.declare_parameter("device", "x", SPECS[2])
    node.destroy_node()


def test_a_fault_of_the_callback_names_the_callback_of_the_program(
    caplog: pytest.LogCaptureFixture,
) -> None:
    node = LifecycleNode(backend=virtual_backend())
    node.declare_parameter("gain", 1.0)

    def of_the_program(parameters: list[Parameter[Any]]) -> SetParametersResult:
        raise ValueError("no")

    node.add_on_set_parameters_callback(of_the_program)
    assert "of_the_program raised ValueError: no" in node.set_parameter("gain", 2.0).reason
    node.destroy_node()


@pytest.mark.parametrize("change_time", ["", "active", None, 1])
def test_another_time_is_an_error(change_time: Any) -> None:
    with pytest.raises(ValueError, match="change_time"):
        ParameterSpec("device", "x", change_time=change_time)


def test_a_callback_of_a_transition_may_set_what_it_has_found() -> None:
    class Finder(LifecycleNode):
        def on_configure(self, previous_state: State) -> CallbackReturn:
            self.result = self.set_parameter("device", "found")
            return CallbackReturn.SUCCESS

    node = Finder(backend=virtual_backend())
    node.declare_parameter("device", "x", SPECS[2])
    node.trigger_configure()
    assert node.result.successful
    assert node.get_parameter("device").value == "found"
    node.destroy_node()
