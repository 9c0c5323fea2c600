"""Services shared with another process: here, two buses of one, over a real socket pair."""

import socket
import threading
from collections.abc import Iterator
from multiprocessing.connection import Connection
from typing import Any

import pytest

from rosbase.contracts.backend import BackendOptions
from rosbase.errors import BackendError, ServiceFailedError, ServiceTimeoutError
from rosbase.local import Bus, LocalBackend
from rosbase.local.link import Link
from support.services import Double, Other, double, spun
from support.waiting import wait_until


class Side:
    """A backend on a bus of its own, and its end of the link."""

    def __init__(self, end: socket.socket, name: str) -> None:
        self.bus = Bus()
        self.backend = LocalBackend(BackendOptions(name), self.bus)
        connection: Connection[Any, Any] = Connection(end.detach())
        self.link = Link(self.bus, connection, name)
        self.link.start()

    def close(self) -> None:
        self.link.close()
        self.backend.close()


@pytest.fixture
def sides() -> Iterator[tuple[Side, Side]]:
    ends = socket.socketpair()
    pair = Side(ends[0], "here"), Side(ends[1], "there")
    yield pair
    for side in pair:
        side.close()


@pytest.fixture
def alone() -> Iterator[tuple[Side, "Connection[Any, Any]"]]:
    """One side, and the bare connection of the other one."""
    ends = socket.socketpair()
    side = Side(ends[0], "here")
    other: Connection[Any, Any] = Connection(ends[1].detach())
    yield side, other
    other.close()
    side.close()


def test_services_are_found_and_answer_in_both_directions(sides: tuple[Side, Side]) -> None:
    for here, there in (sides, sides[::-1]):
        name = f"{there.backend.node_name}_double"
        there.backend.create_service(Double, name, double)
        client = here.backend.create_client(Double, name)
        with spun(there.backend):
            assert [client.call(Double.Request(n)).number for n in range(100)] == [
                2 * n for n in range(100)
            ]


def test_a_service_that_is_destroyed_there_is_absent_here(sides: tuple[Side, Side]) -> None:
    here, there = sides
    service = there.backend.create_service(Double, "double", double)
    client = here.backend.create_client(Double, "double")
    assert client.wait_for_service(20.0)
    future = client.call_async(Double.Request())
    wait_until(lambda: there.backend.executor.ready, "the request")
    there.backend.destroy_service(service)
    wait_until(future.done, "the failure")
    assert str(future.exception()) == "/double failed: it went away before it answered"
    wait_until(lambda: not client.service_is_ready(), "the end of the service")
    there.backend.create_service(Double, "double", double)
    assert client.wait_for_service(20.0)


def test_a_service_of_this_process_comes_before_one_of_another(sides: tuple[Side, Side]) -> None:
    here, there = sides
    there.backend.create_service(Double, "double", lambda _: Double.Response(-1))
    client = here.backend.create_client(Double, "double")
    assert client.wait_for_service(20.0)
    own = here.backend.create_service(Double, "double", double)
    assert client.call(Double.Request(2)).number == 4
    here.backend.destroy_service(own)
    with spun(there.backend):
        assert client.call(Double.Request(2)).number == -1


def test_another_type_there_is_an_error_in_the_log(
    sides: tuple[Side, Side], caplog: pytest.LogCaptureFixture
) -> None:
    here, there = sides
    client = here.backend.create_client(Double, "double")
    there.backend.create_service(Other, "double", lambda _: Other.Response(""))
    wait_until(lambda: "/double is of type Double" in caplog.text, "the report")
    assert not client.service_is_ready()
    here.backend.destroy_client(client)


def test_another_type_here_is_an_error_at_once(sides: tuple[Side, Side]) -> None:
    here, there = sides
    there.backend.create_service(Other, "double", lambda _: Other.Response(""))
    wait_until(lambda: here.bus.services.is_served("/double"), "the service")
    with pytest.raises(BackendError, match="/double is of type Other"):
        here.backend.create_client(Double, "double")


def test_a_request_that_cannot_be_sent_is_an_error_at_once(sides: tuple[Side, Side]) -> None:
    here, there = sides
    there.backend.create_service(Double, "double", double)
    request = Double.Request(threading.Lock())  # type: ignore[arg-type]  # cannot be pickled
    with pytest.raises(ServiceFailedError, match="cannot send request /double: TypeError"):
        here.backend.create_client(Double, "double").call(request)


def test_the_end_of_the_link_ends_its_calls(sides: tuple[Side, Side]) -> None:
    here, there = sides
    there.backend.create_service(Double, "double", double)
    client = here.backend.create_client(Double, "double")
    assert client.wait_for_service(20.0)
    future = client.call_async(Double.Request())
    there.link.close()
    wait_until(future.done, "the failure")
    assert str(future.exception()) == "/double failed: it went away before it answered"
    assert not client.service_is_ready()
    with pytest.raises(ServiceTimeoutError, match="no such service"):
        client.call(Double.Request(), timeout_s=0.01)


def test_services_are_announced_once_by_name_and_type(
    alone: "tuple[Side, Connection[Any, Any]]",
) -> None:
    side, other = alone
    kind = "support.services.Double"
    for is_there in (True, False):
        if is_there:
            service = side.backend.create_service(Double, "double", double)
        else:
            side.backend.destroy_service(service)
        assert other.recv() == ("serve", "/double", kind, is_there)


def test_a_request_for_a_service_that_has_gone_is_answered(
    alone: "tuple[Side, Connection[Any, Any]]",
) -> None:
    _, other = alone
    other.send(("request", "/double", 7, Double.Request()))
    assert other.recv() == ("answer", 7, None, "it went away before it answered")


def test_what_the_other_side_does_not_take_is_limited(
    alone: "tuple[Side, Connection[Any, Any]]",
) -> None:
    side, other = alone
    other.send(("serve", "/double", "support.services.Double", True))
    client = side.backend.create_client(Double, "double")
    assert client.wait_for_service(20.0)
    big = Double.Request("x" * 1_000_000)  # type: ignore[arg-type]  # fills the line
    client.call_async(big)
    futures = [client.call_async(Double.Request(n)) for n in range(1002)]
    text = "/double failed: 1000 requests wait to be sent already"
    assert str(futures[-1].exception()) == text
    for future in futures:
        future.cancel()
    assert other.recv()[0] == "request"
    other.send(("serve", "/other", "support.services.Double", True))
    wait_until(lambda: side.link._services._unsent == 0, "the queue")
    # Those that were cancelled were not sent, and are not remembered.
    assert len(side.link._services._asked) == 1


def test_calls_that_have_ended_are_not_remembered_for_ever(
    alone: "tuple[Side, Connection[Any, Any]]",
) -> None:
    side, other = alone
    other.send(("serve", "/double", "support.services.Double", True))
    client = side.backend.create_client(Double, "double")
    assert client.wait_for_service(20.0)
    for number in range(2500):
        future = client.call_async(Double.Request(number))
        assert other.recv()[2] == number + 1
        future.cancel()
    assert len(side.link._services._asked) <= 1000
    # An answer that comes late is counted, and one that nobody has asked for is dropped.
    other.send(("answer", 2500, Double.Response(), None))
    other.send(("answer", 1, Double.Response(), None))
    other.send(("answer", 5000, Double.Response(), None))
    wait_until(lambda: client.dropped == 1, "the late answer")
