"""Answers to a client that the service has not discovered yet: rmw drops them after 100 ms."""

import threading
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import ListParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.service import Service
from std_srvs.srv import Trigger as RosTrigger
from type_description_interfaces.srv import GetTypeDescription

from rosbase.messages.std_srvs import Trigger
from rosbase.roles.lifecycle_node import LifecycleNode
from rosbase.testing import ManualClock
from rosbase_ros2 import answers
from rosbase_ros2.backend import Ros2Backend
from rosbase_ros2.refusals import RCLError
from support.ros import spin_until
from support.waiting import wait_until

LOST = "failed to send response (timeout): client will not receive response"
DROPPED_FOR_S = 0.11
DROPS = 2
DISCOVERED_AFTER_NS = 25_000_000_000

send_response = Service.send_response


class Rmw:
    """Sends the answers of services, and drops the first ones of each as rmw does."""

    def __init__(self) -> None:
        self.tries: Counter[str] = Counter()

    def send(self, service: Any, response: Any, header: Any) -> None:
        self.tries[service.service_name] += 1
        if self.tries[service.service_name] <= DROPS:
            time.sleep(DROPPED_FOR_S)
            warnings.warn(LOST, RuntimeWarning, stacklevel=1)
        else:
            send_response(service, response, header)


@pytest.fixture
def rmw(monkeypatch: pytest.MonkeyPatch) -> Rmw:
    rmw = Rmw()

    def send(service: Any, response: Any, header: Any) -> None:
        rmw.send(service, response, header)

    monkeypatch.setattr(Service, "send_response", send)
    return rmw


@pytest.fixture
def served(rmw: Rmw, backend: Ros2Backend) -> Ros2Backend:
    """The services that every lifecycle node has."""
    LifecycleNode(backend=backend)
    return backend


@pytest.fixture
def asker(context: Any) -> Iterator[Any]:
    node: Any = rclpy.create_node("asker", context=context)
    yield node
    node.destroy_node()


def ask(asker: Any, served: Ros2Backend, rmw: Rmw, kind: Any, name: str) -> Any:
    """The answer to the first request."""
    client = asker.create_client(kind, name)
    wait_until(client.service_is_ready, "the service")
    future = client.call_async(kind.Request())
    spin_until(served, lambda: rmw.tries[client.service_name])
    executor = SingleThreadedExecutor(context=asker.context)
    executor.add_node(asker)
    executor.spin_until_future_complete(future, 10.0)
    executor.shutdown()
    wait_until(lambda: rmw.tries[client.service_name] > DROPS, "the last try")
    return future.result()


@pytest.mark.parametrize("action", ["error", "ignore"])
def test_an_answer_that_was_dropped_is_sent_again(
    asker: Any, served: Ros2Backend, rmw: Rmw, action: Any
) -> None:
    served.create_service(Trigger, "late", lambda request: Trigger.Response(success=True))
    with warnings.catch_warnings():
        warnings.simplefilter(action, RuntimeWarning)
        answer = ask(asker, served, rmw, RosTrigger, "late")
    assert answer.success


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        (GetState, "get_state"),
        (ChangeState, "change_state"),
        (ListParameters, "list_parameters"),
        (GetTypeDescription, "get_type_description"),
    ],
)
def test_so_is_an_answer_of_the_standard_services_of_a_node(
    asker: Any, served: Ros2Backend, rmw: Rmw, kind: Any, name: str
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        assert ask(asker, served, rmw, kind, f"/test_node/{name}") is not None


def of_python(cause: Exception) -> SystemError:
    """What Python makes of an exception that a function in C has left behind, as rclpy's does."""
    error = SystemError("returned a result with an exception set")
    error.__cause__ = cause
    return error


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (RuntimeWarning(LOST), "the client has not been discovered"),
        (of_python(RuntimeWarning(LOST)), "the client has not been discovered"),
        (RCLError("no room\nleft"), "no room left"),
    ],
)
def test_an_answer_that_is_never_sent_is_one_line_of_warning(
    monkeypatch: pytest.MonkeyPatch, error: Exception, reason: str
) -> None:
    def send(response: Any, header: Any) -> None:
        raise error

    monkeypatch.setattr(answers, "_PATIENCE_NS", 1)
    said: list[str] = []
    answers.Answers(send, "/late", said.append).send("yes", "header")
    wait_until(lambda: said, "the warning")
    assert said == [f"/late: ROS did not send an answer: {reason}"]


def test_an_answer_waits_for_a_client_that_is_discovered_late() -> None:
    clock, said = ManualClock(), list[str]()
    sent = threading.Event()

    def send(response: Any, header: Any) -> None:
        if clock.monotonic_ns() < DISCOVERED_AFTER_NS:
            raise RuntimeWarning(LOST)
        sent.set()

    answers.Answers(send, "/late", said.append, clock).send("yes", "header")
    assert sent.wait(10)
    assert said == []


def test_another_fault_of_a_function_in_c_is_raised() -> None:
    def send(response: Any, header: Any) -> None:
        raise of_python(ValueError("something else"))

    with pytest.raises(SystemError):
        answers.Answers(send, "/late", print).send("yes", "header")
