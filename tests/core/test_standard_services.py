"""The standard services of nodes on `local`: lifecycle and parameters, answered as ROS does."""

import gc
import subprocess
import sys
import threading
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rosbase import (
    BackendOptions,
    BaseManager,
    BaseNode,
    CallbackReturn,
    LifecycleNode,
    LocalBackend,
    ParameterKind,
    ParameterSpec,
    ServiceFailedError,
    ServiceTimeoutError,
    SetParametersResult,
    State,
)
from rosbase.lifecycle import TRANSITIONS
from rosbase.local import Bus
from rosbase.local.service_registry import type_name
from rosbase.local.standard import catalog
from rosbase.local.standard.listing import list_names
from rosbase.messages import lifecycle_msgs, rcl_interfaces
from rosbase.messages.lifecycle_msgs import ChangeState, GetAvailableTransitions, Transition
from rosbase.messages.rcl_interfaces import Parameter, ParameterType, ParameterValue
from rosbase.parameters import Parameter as RosbaseParameter
from rosbase.testing import virtual_backend
from support.program import running
from support.services import Double, double, spun
from support.waiting import wait_until


class Camera(LifecycleNode):
    """Has a lifecycle, and parameters of each kind."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.answer = CallbackReturn.SUCCESS
        for spec in (
            ParameterSpec("fps", 30, "frames per second", minimum=1, maximum=60),
            ParameterSpec("gains.red", 1.5, minimum=0.0),
            ParameterSpec("gains.fine.blue", 2.0),
            ParameterSpec("mode", "slow", choices=("slow", "fast"), change_time="inactive"),
            ParameterSpec("serial", "A1", read_only=True),
            ParameterSpec("key", [b"\x01", b"\xff"]),
            ParameterSpec("names", [], kind=ParameterKind.STRING_ARRAY),
            ParameterSpec("sizes", [1.0, 2.5]),
            ParameterSpec("on", True),
        ):
            self.declare_parameter(spec.name, spec.default, spec)

    def on_configure(self, previous_state: State) -> CallbackReturn:
        return self.answer


class Lamp(BaseNode):
    """Shares the name of its manager."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.declare_parameter("power", 5)


NAMES = ["fps", "gains.red", "gains.fine.blue", "mode", "serial", "key", "names", "sizes", "on"]


@pytest.fixture
def manager() -> Iterator[BaseManager]:
    nodes = {"camera": Camera, "lamp": Lamp}
    made = BaseManager("robot", nodes, backend=virtual_backend(node_name="robot"))
    yield made
    made.backend.close()


def ask(manager: BaseManager, srv_type: Any, name: str, *request: Any, **fields: Any) -> Any:
    """The answer of a service."""
    client = manager.backend.create_client(srv_type, name)
    try:
        return client.call(srv_type.Request(*request, **fields), timeout_s=1.0)
    finally:
        manager.backend.destroy_client(client)


def change(manager: BaseManager, transition_id: int = 0, label: str = "") -> bool:
    wanted = Transition(transition_id, label)
    answer = ask(manager, ChangeState, "camera/change_state", wanted)
    return bool(answer.success)


def set_one(manager: BaseManager, name: str, node: str = "camera", **value: Any) -> Any:
    """The result of setting one parameter."""
    (field, _), *_ = value.items()
    number = getattr(ParameterType, f"PARAMETER_{field.removesuffix('_value').upper()}")
    given = Parameter(name, ParameterValue(type=number, **value))
    (result,) = ask(
        manager, rcl_interfaces.SetParameters, f"{node}/set_parameters", (given,)
    ).results
    return result


# Lifecycle.


def test_a_client_walks_a_node_through_its_life(manager: BaseManager) -> None:
    camera = manager.node(Camera)
    states = []
    for label in ("configure", "activate", "deactivate", "cleanup", "shutdown"):
        assert change(manager, label=label)
        answer = ask(manager, lifecycle_msgs.GetState, "camera/get_state")
        assert answer.current_state.id == camera.get_state().id
        states.append(answer.current_state.label)
    assert states == ["inactive", "active", "inactive", "unconfigured", "finalized"]


def test_a_transition_may_be_asked_for_by_its_number(manager: BaseManager) -> None:
    assert change(manager, Transition.TRANSITION_CONFIGURE)
    assert manager.node(Camera).get_state() is State.INACTIVE


@pytest.mark.parametrize(
    ("wanted", "why"),
    [((0, "activate"), "'activate'"), ((3, ""), "with id 3"), ((99, ""), "with id 99")],
)
def test_a_transition_that_does_not_start_here_is_refused_with_a_line(
    manager: BaseManager, caplog: pytest.LogCaptureFixture, wanted: tuple[int, str], why: str
) -> None:
    assert not change(manager, *wanted)
    assert manager.node(Camera).get_state() is State.UNCONFIGURED
    assert f"/camera/change_state refused: no transition {why} is available" in caplog.text


@pytest.mark.parametrize("answer", [CallbackReturn.FAILURE, CallbackReturn.ERROR])
def test_a_transition_that_fails_is_no_success(
    manager: BaseManager, answer: CallbackReturn
) -> None:
    manager.node(Camera).answer = answer
    assert not change(manager, label="configure")


def test_a_transition_that_a_callback_asks_for_is_refused_as_busy(
    manager: BaseManager, caplog: pytest.LogCaptureFixture
) -> None:
    camera, asked = manager.node(Camera), []

    def on_configure(previous_state: State) -> CallbackReturn:
        asked.append(change(manager, label="configure"))
        return CallbackReturn.SUCCESS

    camera.on_configure = on_configure  # type: ignore[method-assign]  # the test scripts it
    assert change(manager, label="configure")
    assert asked == [False]
    assert "/camera/change_state refused: busy: configuring since 0 s" in caplog.text


def test_the_states_are_listed_in_the_order_of_ros(manager: BaseManager) -> None:
    answer = ask(manager, lifecycle_msgs.GetAvailableStates, "camera/get_available_states")
    found = [(state.id, state.label) for state in answer.available_states]
    assert found == [(state.id, state.label) for state in State]


def test_the_transitions_are_those_of_the_state_and_of_the_graph(manager: BaseManager) -> None:
    def listed(service: str) -> list[tuple[int, str, int, int]]:
        answer = ask(manager, GetAvailableTransitions, f"camera/{service}")
        return [
            (one.transition.id, one.transition.label, one.start_state.id, one.goal_state.id)
            for one in answer.available_transitions
        ]

    assert listed("get_available_transitions") == [
        (1, "configure", 1, 10),
        (5, "shutdown", 1, 12),
    ]
    all_of_them = [(t.id, t.label, t.start.id, t.goal.id) for t in TRANSITIONS]
    assert listed("get_transition_graph") == all_of_them


def test_each_step_is_published(manager: BaseManager) -> None:
    heard: list[lifecycle_msgs.TransitionEvent] = []
    manager.backend.create_subscription(
        lifecycle_msgs.TransitionEvent, "/camera/transition_event", heard.append, 10
    )
    change(manager, label="configure")
    change(manager, label="activate")
    manager.backend.spin_until(10**9, lambda: len(heard) >= 4)
    assert [(one.transition.id, one.start_state.label, one.goal_state.label) for one in heard] == [
        (1, "unconfigured", "configuring"),
        (10, "configuring", "inactive"),
        (3, "inactive", "activating"),
        (30, "activating", "active"),
    ]
    assert heard[0].timestamp == manager.backend.clock.now_ns()


def test_a_topic_of_another_type_gets_no_steps(
    manager: BaseManager, caplog: pytest.LogCaptureFixture
) -> None:
    manager.backend.create_subscription(Transition, "/camera/transition_event", print, 10)
    assert change(manager, label="configure")
    assert caplog.text == ""


def test_changes_of_parameters_are_published_as_those_of_their_node() -> None:
    backend = virtual_backend(node_name="robot")
    heard: list[rcl_interfaces.ParameterEvent] = []
    backend.create_subscription(
        rcl_interfaces.ParameterEvent, "/parameter_events", heard.append, 100
    )
    manager = BaseManager("robot", {"camera": Camera, "lamp": Lamp}, backend=backend)
    backend.spin_until(10**9, lambda: len(heard) > len(NAMES))
    found = [(one.node, one.new_parameters[0].name) for one in heard]
    assert found == [*(("/camera", name) for name in NAMES), ("/robot", "lamp.power")]
    assert heard[0].new_parameters[0].value == ParameterValue(type=2, integer_value=30)
    assert heard[0].stamp == backend.clock.now()
    assert all(len(one.new_parameters) == 1 and not one.changed_parameters for one in heard)
    heard.clear()

    camera, lamp = manager.node(Camera), manager.node(Lamp)
    fast, slow = ParameterValue(type=2, integer_value=60), ParameterValue(type=2, integer_value=2)
    assert set_one(manager, "fps", integer_value=60).successful
    assert not set_one(manager, "fps", integer_value=61).successful
    assert camera.set_parameters(
        [RosbaseParameter("fps", 2), RosbaseParameter("on", False)]
    ).successful
    assert lamp.set_parameter("power", 2).successful
    backend.spin_until(2 * 10**9, lambda: len(heard) >= 3)
    assert [(one.node, one.changed_parameters) for one in heard] == [
        ("/camera", (Parameter("fps", fast),)),
        ("/camera", (Parameter("fps", slow), Parameter("on", ParameterValue(type=1)))),
        ("/robot", (Parameter("lamp.power", slow),)),
    ]
    assert not any(one.new_parameters or one.deleted_parameters for one in heard)
    backend.close()
    lamp.set_parameter("power", 3)


def test_a_second_lifecycle_node_of_one_name_is_named_in_a_warning(
    caplog: pytest.LogCaptureFixture,
) -> None:
    backend = virtual_backend()
    Camera(backend=backend)

    class Other(LifecycleNode):
        pass

    Other(backend=backend)
    assert "Other has no services of its lifecycle: those of /" in caplog.text
    assert "are of its first lifecycle node, Camera" in caplog.text
    backend.close()


# Parameters.


def test_a_lifecycle_node_lists_its_own_parameters_and_the_manager_the_rest(
    manager: BaseManager,
) -> None:
    answer = ask(manager, rcl_interfaces.ListParameters, "camera/list_parameters")
    assert list(answer.result.names) == NAMES
    assert answer.result.prefixes == ("gains", "gains.fine")
    answer = ask(manager, rcl_interfaces.ListParameters, "robot/list_parameters")
    assert answer.result == rcl_interfaces.ListParametersResult(("lamp.power",), ("lamp",))


@pytest.mark.parametrize(
    ("prefixes", "depth", "names", "found"),
    [
        ([], 0, ["a", "b.c", "b.d.e"], ["b", "b.d"]),
        ([], 1, ["a"], []),
        ([], 2, ["a", "b.c"], ["b"]),
        (["b"], 0, ["b.c", "b.d.e"], ["b", "b.d"]),
        (["b"], 1, ["b.c"], ["b"]),
        (["b.d", "a"], 1, ["a", "b.d.e"], ["b.d"]),
        (["b.c"], 1, ["b.c"], ["b"]),
        (["b."], 0, [], []),
        (["x"], 0, [], []),
        ([], -1, [], []),
    ],
)
def test_prefixes_and_depth_limit_a_list(
    prefixes: list[str], depth: int, names: list[str], found: list[str]
) -> None:
    assert list_names(["a", "b.c", "b.d.e"], prefixes, depth) == (names, found)


def test_values_have_their_types(manager: BaseManager) -> None:
    def get(*names: str) -> Any:
        return ask(manager, rcl_interfaces.GetParameters, "camera/get_parameters", names).values

    assert get("fps", "key", "names", "sizes", "on") == (
        ParameterValue(type=2, integer_value=30),
        ParameterValue(type=5, byte_array_value=(1, 255)),
        ParameterValue(type=9),
        ParameterValue(type=8, double_array_value=(1.0, 2.5)),
        ParameterValue(type=1, bool_value=True),
    )
    kinds = ask(
        manager, rcl_interfaces.GetParameterTypes, "camera/get_parameter_types", ("mode", "sizes")
    )
    assert kinds.types == (4, 8)


@pytest.mark.parametrize(
    ("srv_type", "service", "field"),
    [
        (rcl_interfaces.GetParameters, "get_parameters", "values"),
        (rcl_interfaces.GetParameterTypes, "get_parameter_types", "types"),
        (rcl_interfaces.DescribeParameters, "describe_parameters", "descriptors"),
    ],
)
def test_a_name_that_is_not_declared_leaves_the_answer_empty(
    manager: BaseManager, srv_type: Any, service: str, field: str
) -> None:
    for node, names in (("camera", ("fps", "x")), ("robot", ("lamp.power", "camera.fps"))):
        assert getattr(ask(manager, srv_type, f"{node}/{service}", names), field) == ()


def test_descriptors_name_the_limits(manager: BaseManager) -> None:
    answer = ask(
        manager,
        rcl_interfaces.DescribeParameters,
        "camera/describe_parameters",
        ("fps", "gains.red", "mode", "serial"),
    )
    descriptor = rcl_interfaces.ParameterDescriptor
    huge = 1.7976931348623157e308
    assert answer.descriptors == (
        descriptor(
            "fps",
            2,
            "frames per second",
            dynamic_typing=True,
            integer_range=(rcl_interfaces.IntegerRange(1, 60),),
        ),
        descriptor(
            "gains.red",
            3,
            dynamic_typing=True,
            floating_point_range=(rcl_interfaces.FloatingPointRange(0.0, huge),),
        ),
        descriptor(
            "mode",
            4,
            additional_constraints="one of slow, fast; set it while inactive or unconfigured",
            dynamic_typing=True,
        ),
        descriptor("serial", 4, read_only=True, dynamic_typing=True),
    )


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("fps", {"integer_value": 15}, 15),
        ("gains.red", {"integer_value": 2}, 2.0),
        ("gains.red", {"double_value": 0.5}, 0.5),
        ("on", {"bool_value": False}, False),
        ("mode", {"string_value": "fast"}, "fast"),
        ("key", {"byte_array_value": (7,)}, [b"\x07"]),
        ("names", {"string_array_value": ("a", "b")}, ["a", "b"]),
        # What `ros2 param set ... []` sends.
        ("names", {"bool_array_value": ()}, []),
        ("sizes", {"integer_array_value": (1, 2)}, [1.0, 2.0]),
    ],
)
def test_values_are_set_as_those_of_the_declared_type(
    manager: BaseManager, name: str, value: dict[str, Any], expected: Any
) -> None:
    assert set_one(manager, name, **value) == rcl_interfaces.SetParametersResult(successful=True)
    found = manager.node(Camera).get_parameter(name).value
    assert (found, type(found)) == (expected, type(expected))


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("fps", {"integer_value": 61}, "parameter camera.fps is at most 60, not 61"),
        ("fps", {"string_value": "x"}, "parameter camera.fps takes a whole number, not 'x'"),
        ("serial", {"string_value": "B2"}, "parameter camera.serial is read-only"),
        ("x", {"integer_value": 1}, "parameter x has not been declared"),
    ],
)
def test_a_value_that_is_refused_comes_with_the_reason(
    manager: BaseManager, name: str, value: dict[str, Any], reason: str
) -> None:
    assert set_one(manager, name, **value) == rcl_interfaces.SetParametersResult(False, reason)


@pytest.mark.parametrize("number", [0, 42, [1], "1"])
def test_a_value_without_a_type_is_refused(manager: BaseManager, number: Any) -> None:
    given = Parameter("fps", ParameterValue(type=number))
    answer = ask(manager, rcl_interfaces.SetParameters, "camera/set_parameters", (given,))
    assert not answer.results[0].successful
    assert "fps" in answer.results[0].reason
    assert manager.node(Camera).get_parameter("fps").value == 30


def test_the_manager_sets_no_parameter_of_a_lifecycle_node(manager: BaseManager) -> None:
    result = set_one(manager, "camera.fps", "robot", integer_value=15)
    assert result.reason == "parameter camera.fps has not been declared"
    assert set_one(manager, "lamp.power", "robot", integer_value=7).successful
    assert manager.node(Lamp).get_parameter("power").value == 7


def both(manager: BaseManager, srv_type: Any, service: str) -> Any:
    """The answer to a request for one good value and one that is too large."""
    given = [
        Parameter("gains.red", ParameterValue(type=3, double_value=0.5)),
        Parameter("fps", ParameterValue(type=2, integer_value=100)),
    ]
    return ask(manager, srv_type, f"camera/{service}", tuple(given))


def test_parameters_are_set_one_by_one(manager: BaseManager) -> None:
    answer = both(manager, rcl_interfaces.SetParameters, "set_parameters")
    assert [result.successful for result in answer.results] == [True, False]
    assert manager.node(Camera).get_parameter("gains.red").value == 0.5


def test_parameters_set_atomically_are_set_together_or_not_at_all(manager: BaseManager) -> None:
    srv_type = rcl_interfaces.SetParametersAtomically
    answer = both(manager, srv_type, "set_parameters_atomically")
    assert not answer.result.successful
    assert "at most 60" in answer.result.reason
    assert manager.node(Camera).get_parameter("gains.red").value == 1.5


def test_the_callback_of_the_node_may_refuse(manager: BaseManager) -> None:
    asked: list[Any] = []

    def judge(parameters: list[Any]) -> SetParametersResult:
        asked.extend(parameters)
        return SetParametersResult(successful=False, reason="no")

    manager.node(Camera).add_on_set_parameters_callback(judge)
    assert set_one(manager, "fps", integer_value=5).reason == "no"
    assert [(p.name, p.value) for p in asked] == [("fps", 5)]


def test_a_standalone_node_answers_under_its_own_name() -> None:
    camera = Camera(backend=virtual_backend(node_name="eye"))
    client = camera.create_client(lifecycle_msgs.GetState, "/eye/get_state")
    assert client.call(lifecycle_msgs.GetState.Request()).current_state.label == "unconfigured"
    lists = camera.create_client(rcl_interfaces.ListParameters, "~/list_parameters")
    assert list(lists.call(rcl_interfaces.ListParameters.Request()).result.names) == NAMES
    camera.destroy_node()


# Who answers, and for how long.


def test_the_service_of_a_program_comes_before_a_standard_one(manager: BaseManager) -> None:
    manager.backend.create_service(Double, "camera/get_state", double)
    assert ask(manager, Double, "camera/get_state", 4).number == 8


def test_a_client_of_another_type_finds_no_service(manager: BaseManager) -> None:
    with pytest.raises(ServiceTimeoutError, match="/camera/get_state: no such service"):
        ask(manager, Double, "camera/get_state", 4)


def test_a_node_without_a_lifecycle_has_no_services_of_one(manager: BaseManager) -> None:
    for name in ("robot/get_state", "lamp/get_state"):
        client = manager.backend.create_client(lifecycle_msgs.GetState, name)
        assert not client.service_is_ready()


@pytest.fixture
def pair() -> Iterator[tuple[LocalBackend, LocalBackend]]:
    """Two of one world, in real time."""
    bus = Bus()
    made = LocalBackend(BackendOptions("one"), bus), LocalBackend(BackendOptions("two"), bus)
    yield made
    for one in made:
        one.close()


def test_a_request_of_another_thread_is_answered_on_the_thread_that_spins(
    pair: tuple[LocalBackend, LocalBackend],
) -> None:
    one, two = pair
    threads: list[int] = []

    class Node(LifecycleNode):
        def on_configure(self, previous_state: State) -> CallbackReturn:
            threads.append(threading.get_ident())
            return CallbackReturn.SUCCESS

    Node(backend=one)
    client = two.create_client(ChangeState, "/one/change_state")
    with spun(one):
        assert client.call(ChangeState.Request(Transition(label="configure")), 20.0).success
    assert threads
    assert threads[0] != threading.get_ident()


def test_a_call_waits_for_the_node(pair: tuple[LocalBackend, LocalBackend]) -> None:
    one, two = pair
    client = two.create_client(lifecycle_msgs.GetState, "/one/get_state")
    assert not client.service_is_ready()
    call = client.call_async(lifecycle_msgs.GetState.Request())
    LifecycleNode(backend=one)
    assert client.service_is_ready()
    with spun(one):
        wait_until(call.done, "the answer")
    assert call.result().current_state.label == "unconfigured"


def test_requests_end_with_the_backend(pair: tuple[LocalBackend, LocalBackend]) -> None:
    one, two = pair
    LifecycleNode(backend=one)
    client = two.create_client(lifecycle_msgs.GetState, "/one/get_state")
    call = client.call_async(lifecycle_msgs.GetState.Request())
    one.close()
    assert isinstance(call.exception(), ServiceFailedError)
    assert not client.service_is_ready()


def test_of_two_nodes_with_one_name_the_newest_answers_as_long_as_it_is_there() -> None:
    bus = Bus()
    old, new = (LocalBackend(BackendOptions("eye"), bus) for _ in range(2))
    asking = LocalBackend(BackendOptions("asking"), bus)
    LifecycleNode(backend=old).trigger_configure()
    LifecycleNode(backend=new)
    client = asking.create_client(lifecycle_msgs.GetState, "/eye/get_state")

    def state() -> int:
        return int(client.call(lifecycle_msgs.GetState.Request(), 20.0).current_state.id)

    with spun(new):
        assert state() == State.UNCONFIGURED
    new.close()
    with spun(old):
        assert state() == State.INACTIVE
    old.close()
    asking.close()


def test_a_backend_that_nobody_closes_is_not_kept() -> None:
    bus = Bus()
    backend = LocalBackend(BackendOptions("eye"), bus)
    LifecycleNode(backend=backend)
    found = weakref.ref(backend)
    del backend
    gc.collect()
    assert found() is None
    assert not bus.services.is_served("/eye/get_state")


def test_the_types_of_the_catalog_are_those_of_the_messages() -> None:
    for services in catalog.TYPES.values():
        for kind in services.values():
            package, _, name = kind.split(".")[2:]
            assert (
                type_name(getattr(getattr(sys.modules["rosbase.messages"], package), name)) == kind
            )
    assert type_name(lifecycle_msgs.TransitionEvent) == catalog.TRANSITION_EVENT


def test_a_program_that_asks_nothing_imports_no_message_of_these() -> None:
    program = """
import sys
from rosbase import BaseManager, LifecycleNode
from rosbase.testing import virtual_backend

class Node(LifecycleNode):
    autostart = "activate"

manager = BaseManager(nodes_dict={"node": Node}, backend=virtual_backend())
manager.request_stop()
manager.start_main_loop_timer()
assert manager.node(Node).get_state() == 4
print([name for name in sys.modules if "lifecycle_msgs" in name or "rcl_interfaces" in name
       or name.endswith("_answers")])
"""
    done = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    )
    assert done.stdout.splitlines()[-1] == "[]"


# With children.

PROGRAM = """
from rosbase import BaseHandlers, BaseManager, BaseNode, LifecycleNode, register_multiprocess_nodes
from rosbase.messages.lifecycle_msgs import ChangeState, GetState, Transition, TransitionEvent
from rosbase.messages.rcl_interfaces import GetParameters, ListParameters

class Arm(LifecycleNode):
    # A child, which drives a node of its manager when it is configured itself.
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.declare_parameter("speed", 3)
        self.camera = self.create_client(ChangeState, "/camera/change_state")
    def on_configure(self, previous_state):
        self.camera.call(ChangeState.Request(Transition(label="configure")), 20.0)
        return super().on_configure(previous_state)

class Camera(LifecycleNode):
    pass

class Node(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.steps = []
        self.create_subscription(TransitionEvent, "/arm/transition_event", self.note, 10)
    def note(self, event):
        self.steps.append(event.goal_state.label)

class Handlers(BaseHandlers):
    def ask(self, kind, name, *request):
        client = self.node(Node).create_client(kind, name)
        return client.call(kind.Request(*request), 20.0)
    def handle(self):
        if self.timestamp == 0:
            print(self.ask(ListParameters, "/arm/list_parameters").result.names)
            print(self.ask(GetParameters, "/arm/get_parameters", ("speed",)).values)
            wanted = Transition(label="configure")
            print(self.ask(ChangeState, "/arm/change_state", wanted).success)
            print(self.ask(GetState, "/arm/get_state").current_state.label)
            print(self.node(Camera).get_state())
        if len(self.node(Node).steps) == 2:
            print(self.node(Node).steps)
            self.manager.request_stop()

if __name__ == "__main__":
    processes = register_multiprocess_nodes({"arm": Arm}, {})
    manager = BaseManager(nodes_dict={"node": Node, "camera": Camera}, handlers_class=Handlers)
    manager.start_main_loop_timer(processes)
"""


def test_a_manager_and_its_child_ask_each_other(tmp_path: Path) -> None:
    with running(tmp_path, PROGRAM) as program:
        status, out, err = program.end()
    assert status == 0, err
    assert out.splitlines() == [
        "('speed',)",
        f"{(ParameterValue(type=2, integer_value=3),)}",
        "True",
        "inactive",
        "inactive",
        "['configuring', 'inactive']",
    ]
