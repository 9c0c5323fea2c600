"""The standard services of `local` against rclpy's: one node on each backend is asked the same.

Both are asked directly, not over a network. Only the reasons of refusals are worded otherwise.
"""

from collections.abc import Callable, Iterator
from typing import Any

import attrs
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lifecycle_msgs import srv as lifecycle_services
from rcl_interfaces import msg, srv

from rosbase import BackendOptions, LifecycleNode, LocalBackend, ParameterKind, ParameterSpec
from rosbase.local import Bus
from rosbase.messages import lifecycle_msgs, rcl_interfaces
from rosbase.messages.rcl_interfaces import Parameter, ParameterValue
from rosbase.parameters import Parameter as RosbaseParameter
from rosbase_ros2.backend import Ros2Backend

SPECS = [
    ParameterSpec("fps", 30, "frames per second", minimum=1, maximum=60),
    ParameterSpec("gains.red", 1.5, minimum=0.0),
    ParameterSpec("gains.fine.blue", 2.0),
    ParameterSpec("gainsay", "no"),
    ParameterSpec("mode", "slow", choices=("slow", "fast"), change_time="inactive"),
    ParameterSpec("serial", "A1", read_only=True),
    ParameterSpec("key", [b"\x01", b"\xff"]),
    ParameterSpec("names", [], kind=ParameterKind.STRING_ARRAY),
    ParameterSpec("sizes", [1.0, 2.5]),
    ParameterSpec("ids", [1, 2], minimum=0),
    ParameterSpec("flags", [True, False]),
    ParameterSpec("on", True),
]
# Those of every node of rclpy.
OF_RCLPY = {"use_sim_time", "start_type_description_service"}
NAMES = st.lists(st.sampled_from([spec.name for spec in SPECS]), max_size=4)
PREFIXES = st.lists(
    st.sampled_from(["gains", "gains.fine", "gains.", "gain", "fps", "x", "", "."]), max_size=3
)


class Eye(LifecycleNode):
    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        for spec in SPECS:
            self.declare_parameter(spec.name, spec.default, spec)


class Twins:
    """One node on each backend."""

    def __init__(self) -> None:
        self.local = LocalBackend(BackendOptions("eye"), Bus())
        self.ros2 = Ros2Backend(BackendOptions("eye"))
        self.nodes = Eye(backend=self.local), Eye(backend=self.ros2)
        self._callbacks: dict[str, Callable[[Any, Any], Any]] = {
            service.srv_name.rpartition("/")[2]: service.callback
            for service in self.ros2.node.entities("services")
        }

    def ask(self, service: str, kind: Any, ros_kind: Any, request: Any) -> tuple[Any, Any]:
        """The answers of `local` and of rclpy, as plain values."""
        client = self.local.create_client(kind, f"/eye/{service}")
        ours = client.call(request)
        self.local.destroy_client(client)
        theirs = self._callbacks[service](to_ros(request), ros_kind.Response())
        return plain(ours), plain(theirs)

    def close(self) -> None:
        for node in self.nodes:
            node.destroy_node()


@pytest.fixture(scope="module")
def twins(warm_ros: None) -> Iterator[Twins]:
    made = Twins()
    yield made
    made.close()


@pytest.fixture
def new_twins(warm_ros: None) -> Iterator[Twins]:
    made = Twins()
    yield made
    made.close()


def plain(value: Any) -> Any:
    """A message as dicts, lists and numbers."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if attrs.has(type(value)):
        return {one.name: plain(getattr(value, one.name)) for one in attrs.fields(type(value))}
    if isinstance(value, bytes):
        return value[0]
    if isinstance(value, (str, bool, int, float)):
        return value
    return [plain(item) for item in value]


def to_ros(value: Any) -> Any:
    """The same message of ROS."""
    if not attrs.has(type(value)):
        return [to_ros(item) for item in value] if isinstance(value, tuple) else value
    name, _, part = type(value).__name__.partition("_")
    found = next(getattr(p, name) for p in (msg, srv, lifecycle_services) if hasattr(p, name))
    made = (getattr(found, part) if part else found)()
    for one in attrs.fields(type(value)):
        content = to_ros(getattr(value, one.name))
        if one.name == "byte_array_value":
            content = [bytes((item,)) for item in content]
        setattr(made, one.name, content)
    return made


def test_events_of_parameters_are_those_of_rclpy(
    new_twins: Twins, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours: list[Any] = []
    theirs: list[Any] = []
    new_twins.local.create_subscription(
        rcl_interfaces.ParameterEvent, "/parameter_events", ours.append, 100
    )
    publisher: Any = new_twins.ros2.node._parameter_event_publisher
    monkeypatch.setattr(publisher, "publish", theirs.append)
    for node in new_twins.nodes:
        node.declare_parameter("late", [1.5])
        node.set_parameters([RosbaseParameter("fps", 31), RosbaseParameter("late", [2.5])])
        node.set_parameter("fps", 31)
        node.set_parameter("fps", 99)
        node.set_parameter("key", [b"\x02"])
    new_twins.local.spin_until(
        new_twins.local.clock.monotonic_ns() + 10**10, lambda: len(ours) >= len(theirs)
    )
    assert len(ours) == 4
    assert [without_stamp(one) for one in ours] == [without_stamp(one) for one in theirs]


def without_stamp(event: Any) -> Any:
    """An event as plain values that do not depend on the time."""
    return plain(event) | {"stamp": None}


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(prefixes=PREFIXES, depth=st.integers(0, 4))
def test_lists_are_those_of_rclpy(twins: Twins, prefixes: list[str], depth: int) -> None:
    request = rcl_interfaces.ListParameters.Request(tuple(prefixes), depth)
    ours, theirs = twins.ask(
        "list_parameters", rcl_interfaces.ListParameters, srv.ListParameters, request
    )
    names = [name for name in theirs["result"]["names"] if name not in OF_RCLPY]
    assert ours["result"] == {"names": names, "prefixes": theirs["result"]["prefixes"]}


@pytest.mark.parametrize(
    ("service", "kind"),
    [
        ("get_parameters", "GetParameters"),
        ("get_parameter_types", "GetParameterTypes"),
        ("describe_parameters", "DescribeParameters"),
    ],
)
@pytest.mark.parametrize("names", [[], [s.name for s in SPECS], ["fps", "x"], ["x"], [""]])
def test_values_types_and_descriptors_are_those_of_rclpy(
    twins: Twins, service: str, kind: str, names: list[str]
) -> None:
    ours_kind = getattr(rcl_interfaces, kind)
    request = ours_kind.Request(tuple(names))
    ours, theirs = twins.ask(service, ours_kind, getattr(srv, kind), request)
    assert ours == theirs


GIVEN = [
    ("fps", ParameterValue(type=2, integer_value=15)),
    ("fps", ParameterValue(type=2, integer_value=61)),
    ("fps", ParameterValue(type=3, double_value=15.0)),
    ("fps", ParameterValue(type=4, string_value="15")),
    ("gains.red", ParameterValue(type=2, integer_value=2)),
    ("gains.red", ParameterValue(type=3, double_value=-1.0)),
    ("gains.red", ParameterValue(type=3, double_value=float("inf"))),
    ("mode", ParameterValue(type=4, string_value="fast")),
    ("mode", ParameterValue(type=4, string_value="odd")),
    ("serial", ParameterValue(type=4, string_value="A1")),
    ("key", ParameterValue(type=5, byte_array_value=(7, 0))),
    ("key", ParameterValue(type=7, integer_array_value=(7, 0))),
    ("names", ParameterValue(type=9, string_array_value=("a", "b"))),
    ("names", ParameterValue(type=6)),
    ("sizes", ParameterValue(type=7, integer_array_value=(1, 2))),
    ("sizes", ParameterValue(type=8, double_array_value=(0.5,))),
    ("ids", ParameterValue(type=7, integer_array_value=(-1,))),
    ("flags", ParameterValue(type=6, bool_array_value=(True,))),
    ("on", ParameterValue(type=1)),
    ("fps", ParameterValue()),
    ("x", ParameterValue(type=2, integer_value=1)),
]


@pytest.mark.parametrize("service", ["set_parameters", "set_parameters_atomically"])
def test_what_is_set_and_what_is_refused_is_that_of_rclpy(new_twins: Twins, service: str) -> None:
    is_atomic = service.endswith("atomically")
    name = "SetParametersAtomically" if is_atomic else "SetParameters"
    kind, ros_kind = getattr(rcl_interfaces, name), getattr(srv, name)
    get = rcl_interfaces.GetParameters
    all_names = get.Request(tuple(spec.name for spec in SPECS))
    for one in GIVEN:
        other = Parameter("gainsay", ParameterValue(type=4, string_value=f"{one}"))
        request = kind.Request((other, Parameter(*one)))
        ours, theirs = new_twins.ask(service, kind, ros_kind, request)
        for answer in (ours, theirs):
            for result in [answer["result"]] if is_atomic else answer["results"]:
                assert bool(result["reason"]) is not result["successful"]
                result["reason"] = ""
        assert ours == theirs, one
        ours, theirs = new_twins.ask("get_parameters", get, srv.GetParameters, all_names)
        assert ours == theirs, one


def test_states_and_transitions_are_those_of_the_other_backend(new_twins: Twins) -> None:
    services = {
        "get_state": "GetState",
        "get_available_states": "GetAvailableStates",
        "get_available_transitions": "GetAvailableTransitions",
        "get_transition_graph": "GetAvailableTransitions",
    }
    for label in ("configure", "activate", "deactivate", "cleanup", "shutdown"):
        for service, kind in services.items():
            ours_kind, ros_kind = getattr(lifecycle_msgs, kind), getattr(lifecycle_services, kind)
            ours, theirs = new_twins.ask(service, ours_kind, ros_kind, ours_kind.Request())
            assert ours == theirs
        for node in new_twins.nodes:
            node.request_transition(label=label)
