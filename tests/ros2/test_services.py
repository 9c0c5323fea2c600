"""Services and clients of rosbase, with rclpy on the other side of them and without."""

import gc
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from typing import Any

import pytest
from attrs import frozen
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.task import Future
from std_srvs.srv import SetBool as RosSetBool
from std_srvs.srv import Trigger as RosTrigger

from rosbase import (
    BackendError,
    BaseManager,
    BaseNode,
    LifecycleNode,
    Parameter,
    ParameterSpec,
    ServiceError,
    ServiceFailedError,
    ServiceTimeoutError,
    SetParametersResult,
    State,
)
from rosbase.messages.fields import UInt32, message
from rosbase.messages.lifecycle_msgs import ChangeState, Transition
from rosbase.messages.rcl_interfaces import Parameter as RosParameter
from rosbase.messages.rcl_interfaces import ParameterValue, SetParameters
from rosbase.messages.std_srvs import Empty, SetBool, Trigger
from rosbase_ros2 import services
from rosbase_ros2.backend import Ros2Backend
from support.ros import TIMEOUT_S, Open, spin_until
from support.ros_services import Plain, on_thread, plain_node
from support.waiting import wait_until


@pytest.fixture
def plain(warm_ros: None) -> Iterator[Plain]:
    with plain_node() as node:
        yield node


@pytest.fixture
def over_the_network(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if the ends were in different processes."""
    monkeypatch.setattr(services.Services, "_find", lambda self, key: None)


def opposite(request: Any) -> Any:
    """Answers a SetBool of rosbase."""
    return SetBool.Response(not request.data, "opposite")


def ros_opposite(request: Any, response: Any) -> Any:
    """Answers a SetBool of ROS."""
    response.success, response.message = not request.data, "opposite"
    return response


def answering(text: str) -> Callable[[Any], Any]:
    """A callback that answers a Trigger of rosbase."""
    return lambda request: Trigger.Response(success=True, message=text)


def beside(backend: Ros2Backend, work: Callable[[], Any]) -> Any:
    """Does it on another thread while the main loop runs; gives the result."""
    thread, found = on_thread(work)
    spin_until(backend, lambda: not thread.is_alive())
    thread.join()
    if isinstance(found[0], Exception):
        raise found[0]
    return found[0]


def answered(backend: Ros2Backend, begin: Callable[[], Any]) -> Any:
    """The answer to a request of plain rclpy."""
    future = beside(backend, begin)
    spin_until(backend, future.done)
    return future.result()


# With plain rclpy.


@pytest.mark.parametrize(
    ("kind", "callback"), [(SetBool, opposite), (RosSetBool, ros_opposite)], ids=["ours", "ROS's"]
)
def test_a_plain_client_calls_our_service(
    backend: Ros2Backend, plain: Plain, kind: Any, callback: Any
) -> None:
    service = backend.create_service(kind, "~/opposite", callback)
    assert service.service_name == "/test_node/opposite"
    for data in (True, False):
        answer = answered(backend, partial(plain.ask_for_bool, "/test_node/opposite", data))
        assert (answer.success, answer.message) == (not data, "opposite")


@pytest.mark.parametrize("kind", [SetBool, RosSetBool], ids=["ours", "ROS's"])
def test_our_client_calls_a_plain_service(backend: Ros2Backend, plain: Plain, kind: Any) -> None:
    plain.serve(RosSetBool, "set", success=True, message="done")
    answer = backend.create_client(kind, "set").call(kind.Request(data=True), timeout_s=TIMEOUT_S)
    assert isinstance(answer, kind.Response)
    assert (answer.success, answer.message) == (True, "done")
    assert [request.data for request in plain.served] == [True]


def test_a_service_without_fields_answers(backend: Ros2Backend, plain: Plain) -> None:
    plain.serve(RosTrigger, "trigger", success=True)
    backend.create_service(Empty, "empty", lambda request: Empty.Response())
    assert backend.create_client(Trigger, "trigger").call(Trigger.Request()).success
    assert backend.create_client(Empty, "empty").call(Empty.Request()) == Empty.Response()


def test_a_service_asks_a_plain_one_before_it_answers(backend: Ros2Backend, plain: Plain) -> None:
    plain.serve(RosTrigger, "inner", success=True, message="inner")
    inner = backend.create_client(Trigger, "inner")
    backend.create_service(Trigger, "outer", lambda _: inner.call(Trigger.Request()))
    assert answered(backend, lambda: plain.trigger("outer")).message == "inner"


def test_a_burst_of_calls_is_answered_whole(backend: Ros2Backend, plain: Plain) -> None:
    plain.serve(RosTrigger, "trigger", success=True)
    client = backend.create_client(Trigger, "trigger")
    assert client.wait_for_service(TIMEOUT_S)
    plain.delay.clear()
    futures = [client.call_async(Trigger.Request(), timeout_s=TIMEOUT_S) for _ in range(9)]
    plain.delay.set()
    spin_until(backend, lambda: all(future.done() for future in futures))
    assert all(future.result().success for future in futures)


def test_more_requests_may_wait_for_our_service_than_dds_keeps_by_default(
    backend: Ros2Backend, opened: Open, over_the_network: None
) -> None:
    other, served = opened(), list[Any]()

    def answer(request: Any) -> Any:
        served.append(request)
        return Trigger.Response(success=True)

    backend.create_service(Trigger, "trigger", answer)
    client = other.create_client(Trigger, "trigger")
    assert client.wait_for_service(TIMEOUT_S)
    futures = [client.call_async(Trigger.Request(), timeout_s=TIMEOUT_S) for _ in range(500)]
    spin_until(backend, lambda: len(served) == 500)
    spin_until(other, lambda: all(future.done() for future in futures))
    assert all(future.result().success for future in futures)


def test_a_request_that_waits_for_the_main_loop_holds_nothing_up(
    backend: Ros2Backend, plain: Plain
) -> None:
    backend.create_service(Trigger, "trigger", lambda _: Trigger.Response(success=True))
    waiting = plain.trigger("trigger")
    others = [plain.ask(GetParameters, "/test_node/get_parameters") for _ in range(3)]
    # Nobody spins the main loop.
    wait_until(lambda: all(future.done() for future in others), "the answers of rclpy's thread")
    assert not waiting.done()
    spin_until(backend, waiting.done)
    assert waiting.result().success


# What goes wrong.


def test_a_plain_service_that_goes_away_fails_the_call(backend: Ros2Backend, plain: Plain) -> None:
    never: Any = Future()

    async def answer(request: Any, response: Any) -> Any:
        plain.served.append(request)
        await never

    service = plain.node.create_service(RosTrigger, "trigger", answer)
    client = backend.create_client(Trigger, "trigger")
    future = client.call_async(Trigger.Request(), timeout_s=600.0)
    wait_until(lambda: plain.served, "the request")
    plain.node.destroy_service(service)
    spin_until(backend, future.done)
    with pytest.raises(ServiceFailedError, match=r"^/trigger failed: it went away before"):
        future.result()


def test_late_answers_of_a_plain_service_are_counted(backend: Ros2Backend, plain: Plain) -> None:
    plain.serve(RosTrigger, "trigger", success=True)
    client = backend.create_client(Trigger, "trigger")
    assert client.wait_for_service(TIMEOUT_S)
    plain.delay.clear()
    for _ in range(3):
        with pytest.raises(ServiceTimeoutError, match=r"^/trigger: no answer after 0\.05 s$"):
            client.call(Trigger.Request(), timeout_s=0.05)
    kept = client.call_async(Trigger.Request())
    kept.cancel()
    gc.collect()
    plain.delay.set()
    wait_until(lambda: client.dropped == 4, "the late answers")
    assert client.call(Trigger.Request()).success
    assert client.dropped == 4


def test_a_failed_callback_is_told_within_the_process_and_logged_for_others(
    backend: Ros2Backend, opened: Open, plain: Plain, caplog: pytest.LogCaptureFixture
) -> None:
    requests: list[Any] = []

    def answer(request: Any) -> Any:
        requests.append(request)
        raise ArithmeticError("stuck")

    backend.create_service(Trigger, "trigger", answer)
    with pytest.raises(ServiceFailedError, match=r"^/trigger failed: ArithmeticError: stuck$"):
        backend.create_client(Trigger, "trigger").call(Trigger.Request(), timeout_s=600.0)
    # In the same process, with another context.
    client = opened().create_client(RosTrigger, "trigger")
    with pytest.raises(ServiceFailedError, match=r"^/trigger failed: ArithmeticError: stuck$"):
        beside(backend, lambda: client.call(RosTrigger.Request(), timeout_s=600.0))
    future = beside(backend, lambda: plain.trigger("trigger"))
    spin_until(backend, lambda: len(requests) == 3)
    assert not future.done()
    assert caplog.messages == ["/trigger failed: ArithmeticError: stuck"] * 3


def test_answers_that_ros_cannot_send_are_failures(backend: Ros2Backend) -> None:
    def answer(request: Any) -> Any:
        return Trigger.Response(True, 5)  # type: ignore[arg-type]  # the mistake is the test

    backend.create_service(Trigger, "trigger", answer)
    with pytest.raises(ServiceFailedError, match=r"^/trigger failed: TypeError: .*message"):
        backend.create_client(Trigger, "trigger").call(Trigger.Request())


def test_requests_that_ros_cannot_send_are_errors(backend: Ros2Backend) -> None:
    client = backend.create_client(SetBool, "absent")
    wrong = SetBool.Request(data="yes")  # type: ignore[arg-type]  # the mistake is the test
    for call in (client.call, client.call_async):
        with pytest.raises(TypeError, match="data"):
            call(wrong)


def test_requests_that_are_too_many_get_no_answer_and_a_line(
    backend: Ros2Backend, opened: Open, over_the_network: None, caplog: pytest.LogCaptureFixture
) -> None:
    other = opened()
    backend.create_service(Trigger, "trigger", lambda _: Trigger.Response(success=True))
    client = other.create_client(Trigger, "trigger")
    assert client.wait_for_service(TIMEOUT_S)
    line = "/trigger: a request gets no answer: /trigger failed: 1000 requests wait for it already"
    futures: list[Any] = []

    def is_full() -> bool:
        # Not more at a time than DDS keeps.
        futures.extend(client.call_async(Trigger.Request(), TIMEOUT_S) for _ in range(20))
        return line in caplog.messages

    wait_until(is_full, "the line")
    assert caplog.messages == [line]
    # Those that wait are answered. On a busy machine, DDS loses some of so many.
    spin_until(backend, lambda: any(one.done() and not one.exception() for one in futures))


def test_a_callback_of_rclpy_may_not_wait_but_may_call(backend: Ros2Backend) -> None:
    backend.create_service(Trigger, "trigger", lambda _: Trigger.Response(success=True))
    client = backend.create_client(Trigger, "trigger")
    found: list[Any] = []

    def native(request: Any, response: Any) -> Any:
        for wait in (lambda: client.call(Trigger.Request()), client.wait_for_service):
            with pytest.raises(ServiceError) as caught:
                wait()
            found.append(str(caught.value))
        found.append(client.call_async(Trigger.Request()))
        return response

    backend.node.create_service(RosTrigger, "native", native)
    beside(backend, lambda: backend.create_client(RosTrigger, "native").call(RosTrigger.Request()))
    line = "/trigger: a callback of rclpy may not wait for a service: use call_async there"
    assert found[:2] == [line, line]
    spin_until(backend, found[2].done)
    assert found[2].result().success


def test_a_callback_that_runs_in_a_call_is_no_callback_of_rclpy(
    backend: Ros2Backend, plain: Plain
) -> None:
    backend.create_service(Trigger, "one", lambda _: Trigger.Response(success=True))
    one = backend.create_client(Trigger, "one")
    heard: list[bool] = []
    one.call_async(Trigger.Request()).add_done_callback(
        lambda _: heard.append(one.call(Trigger.Request()).success)
    )
    spin_until(backend, lambda: heard)
    assert heard == [True]


def test_with_use_sim_time_timeouts_are_on_the_clock_of_the_machine(opened: Open) -> None:
    backend = opened("-p", "use_sim_time:=true")
    client = backend.create_client(Trigger, "absent")
    with pytest.raises(ServiceTimeoutError, match=r"^/absent: no such service after 0\.1 s$"):
        client.call(Trigger.Request(), timeout_s=0.1)
    future = client.call_async(Trigger.Request(), timeout_s=0.1)
    spin_until(backend, future.done)
    assert isinstance(future.exception(), ServiceTimeoutError)


def test_a_call_ends_with_the_context(backend: Ros2Backend) -> None:
    client = backend.create_client(Trigger, "absent")
    backend.node.context.shutdown()
    assert not client.service_is_ready()
    with pytest.raises(ServiceTimeoutError):
        client.call(Trigger.Request(), timeout_s=0.05)


# Types.


@message("no_such_pkg/srv/Open_Request")
@frozen
class OpenRequest:
    pass


@message("no_such_pkg/srv/Open_Response")
@frozen
class OpenResponse:
    pass


class OpenDoor:
    Request, Response = OpenRequest, OpenResponse


@message("std_srvs/srv/Trigger_Response")
@frozen
class WideResponse:
    success: bool = False
    code: UInt32 = 0


class Wide:
    Request, Response = Trigger.Request, WideResponse


class Half:
    Request, Response = Trigger.Request, SetBool.Response


@pytest.mark.parametrize(
    ("kind", "line"),
    [
        (
            OpenDoor,
            "service 'open': OpenDoor is no_such_pkg/srv/Open in ROS, and no_such_pkg is not"
            " installed: pip install ros-jazzy-no-such-pkg, or source a workspace that has it",
        ),
        (
            Wide,
            "service 'open': WideResponse differs from std_srvs/srv/Trigger_Response of ROS: it has"
            " uint32 code, where ROS has string message",
        ),
        (
            Half,
            f"service 'open': {__name__}.Half is a type of neither rosbase nor ROS: its classes"
            " Request and Response are no messages such as pkg/srv/Name_Request and"
            " pkg/srv/Name_Response",
        ),
    ],
)
def test_a_type_that_ros_does_not_have_is_one_line(
    backend: Ros2Backend, kind: Any, line: str
) -> None:
    for create in (
        partial(backend.create_service, kind, "open", opposite),
        partial(backend.create_client, kind, "open"),
    ):
        with pytest.raises(BackendError) as caught:
            create()
        assert str(caught.value) == line


def test_a_service_has_one_type_and_one_callback(backend: Ros2Backend) -> None:
    backend.create_service(RosTrigger, "trigger", lambda request, response: response)
    backend.create_client(Trigger, "trigger")
    with pytest.raises(BackendError, match=r"^service 'trigger': it is a std_srvs\S*Trigger, so"):
        backend.create_client(SetBool, "trigger")
    line = "^service '/trigger': there is one in this process already$"
    with pytest.raises(BackendError, match=line):
        backend.create_service(Trigger, "/trigger", opposite)
    with pytest.raises(BackendError, match=r"there is one in this process already$"):
        backend.create_service(ListParameters, "~/list_parameters", opposite)


def test_a_service_of_another_backend_with_another_type_is_absent(
    backend: Ros2Backend, opened: Open
) -> None:
    backend.create_service(RosTrigger, "trigger", lambda request, response: response)
    client = opened().create_client(SetBool, "trigger")
    with pytest.raises(ServiceTimeoutError, match="no such service"):
        client.call(SetBool.Request(), timeout_s=0.1)


def test_the_second_of_two_backends_with_one_service_answers_when_the_first_has_ended(
    backend: Ros2Backend, opened: Open
) -> None:
    first, second = opened(), opened()
    made = [
        one.create_service(Trigger, "trigger", answering(name))
        for one, name in ((first, "first"), (second, "second"))
    ]
    client = backend.create_client(Trigger, "trigger")
    assert beside(first, lambda: client.call(Trigger.Request()).message) == "first"
    first.destroy_service(made[0])
    assert beside(second, lambda: client.call(Trigger.Request()).message) == "second"
    second.destroy_service(made[1])
    wait_until(lambda: not client.service_is_ready(), "the end of both")


def test_both_sides_may_change_their_ros_messages(backend: Ros2Backend) -> None:
    seen: list[Any] = []

    def answer(request: Any, response: Any) -> Any:
        seen.extend((request, response))
        response.result.names = ["one"]
        return response

    backend.create_service(ListParameters, "list", answer)
    client, request = backend.create_client(ListParameters, "list"), ListParameters.Request(depth=3)
    future = client.call_async(request)
    request.depth = 4
    spin_until(backend, future.done)
    seen[1].result.names = ["two"]
    assert (seen[0].depth, future.result().result.names) == (3, ["one"])


def test_one_ros_request_that_is_changed_while_its_service_is_absent_arrives_as_it_was(
    backend: Ros2Backend, plain: Plain
) -> None:
    client, request = backend.create_client(RosSetBool, "late"), RosSetBool.Request()
    futures: list[Any] = []
    for data in (True, False, True, False):
        request.data = data
        futures.append(client.call_async(request, timeout_s=TIMEOUT_S))
    plain.serve(RosSetBool, "late", success=True)
    spin_until(backend, lambda: all(future.done() for future in futures))
    assert [served.data for served in plain.served] == [True, False, True, False]


# Names and nodes.


def test_names_are_remapped_as_those_of_topics(opened: Open, plain: Plain) -> None:
    backend = opened("-r", "__ns:=/robot", "-r", "open:=close", "-r", "asked:=/set")
    service = backend.create_service(SetBool, "open", opposite)
    assert service.service_name == "/robot/close"
    plain.serve(RosSetBool, "/set", success=True)
    client = backend.create_client(SetBool, "asked")
    assert client.service_name == "/set"
    assert client.call(SetBool.Request(), timeout_s=TIMEOUT_S).success
    assert answered(backend, lambda: plain.ask_for_bool("/robot/close", False)).success


class Gripper(LifecycleNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.create_service(SetBool, "~/close", opposite)


class Camera(BaseNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.create_service(SetBool, "~/expose", opposite)


def test_a_service_of_a_lifecycle_node_is_on_its_own_ros_node(opened: Open, plain: Plain) -> None:
    backend = opened()
    nodes = {"left": Gripper, "right": Gripper, "camera": Camera}
    BaseManager("driver", nodes, backend=backend)
    for name in ("left/close", "right/close", "driver/expose"):
        assert answered(backend, partial(plain.ask_for_bool, f"/{name}", False)).success
        node, _, own = name.partition("/")
        found = dict(plain.node.get_service_names_and_types_by_node(node, "/"))
        assert found[f"/{node}/{own}"] == ["std_srvs/srv/SetBool"]
        client = backend.create_client(SetBool, f"/{name}")
        assert client.call(SetBool.Request()).success


def test_a_call_of_a_standard_service_of_the_same_manager_is_answered(opened: Open) -> None:
    backend = opened()
    manager = BaseManager("driver", {"left": Gripper}, backend=backend)
    change = backend.create_client(ChangeState, "left/change_state")
    configure = ChangeState.Request(Transition(label="configure"))
    assert change.call(configure, timeout_s=TIMEOUT_S).success
    assert manager.nodes["left"].get_state() is State.INACTIVE
    backend.declare_parameter(ParameterSpec("speed", 1.0))
    asked: list[float] = []

    def allow(parameters: list[Parameter[Any]]) -> SetParametersResult:
        asked.extend(one.value for one in parameters)
        return SetParametersResult(successful=True)

    backend.add_on_set_parameters_callback(allow)
    request = SetParameters.Request(
        parameters=(RosParameter("speed", ParameterValue(type=3, double_value=2.0)),)
    )
    client = backend.create_client(SetParameters, "~/set_parameters")
    assert client.call(request, timeout_s=TIMEOUT_S).results[0].successful
    assert asked == [backend.get_parameter("speed").value] == [2.0]


# What it costs.


def test_nothing_looks_for_services_without_calls(backend: Ros2Backend, plain: Plain) -> None:
    def timers() -> list[Any]:
        return list(backend.node.entities("timers"))

    plain.serve(RosTrigger, "trigger", success=True)
    client = backend.create_client(Trigger, "trigger")
    assert client.wait_for_service(TIMEOUT_S)
    assert not timers()
    client.call(Trigger.Request())
    wait_until(timers, "the timer that looks for the service")
    wait_until(lambda: not timers(), "the end of the timer")
    client.call(Trigger.Request())
    wait_until(timers, "the timer to begin again")


def test_ended_ends_leave_nothing_on_the_node(backend: Ros2Backend) -> None:
    def ends() -> int:
        return sum(1 for kind in ("services", "clients") for _ in backend.node.entities(kind))

    before = ends()
    for _ in range(3):
        service = backend.create_service(Trigger, "t", lambda _: Trigger.Response(success=True))
        client = backend.create_client(Trigger, "t")
        assert client.call(Trigger.Request()).success
        backend.destroy_service(service)
        backend.destroy_client(client)
    wait_until(lambda: ends() == before, "the ends to be destroyed")


def test_a_client_that_has_gone_ends_nothing(backend: Ros2Backend, plain: Plain) -> None:
    with ExitStack() as stack:
        passing = stack.enter_context(plain_node("passing"))
        answers: list[Any] = []

        def answer(request: Any) -> Any:
            # A client that is destroyed earlier can lose the request that it has just sent.
            stack.close()
            answers.append(request)
            return Trigger.Response(success=True)

        backend.create_service(Trigger, "trigger", answer)
        future = passing.trigger("trigger")
        spin_until(backend, lambda: answers)
    assert not future.done()
    assert answered(backend, lambda: plain.trigger("trigger")).success
