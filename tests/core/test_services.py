"""Services within one process: calls and their answers, and what goes wrong with them."""

import threading
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import attrs
import pytest

from rosbase import (
    BackendError,
    BackendOptions,
    BaseNode,
    LifecycleNode,
    LocalBackend,
    ServiceDepthError,
    ServiceError,
    ServiceFailedError,
    ServiceTimeoutError,
)
from rosbase.contracts.backend import Backend
from rosbase.local import Bus
from rosbase.messages import String
from rosbase.testing import virtual_backend
from support.services import Double, Other, double, spun
from support.waiting import wait_until


@pytest.fixture
def backend() -> Iterator[LocalBackend]:
    """In virtual time, with topics and services of its own."""
    made = virtual_backend()
    yield made
    made.close()


@pytest.fixture
def pair() -> Iterator[tuple[LocalBackend, LocalBackend]]:
    """Two of one world, in real time."""
    bus = Bus()
    made = LocalBackend(BackendOptions("one"), bus), LocalBackend(BackendOptions("two"), bus)
    yield made
    for one in made:
        one.close()


def ask(backend: Backend, name: str, number: int = 1, timeout_s: float = 5.0) -> int:
    """Calls a service of numbers once."""
    client = backend.create_client(Double, name)
    try:
        return client.call(Double.Request(number), timeout_s=timeout_s).number
    finally:
        backend.destroy_client(client)


def noting(heard: list[Any]) -> Callable[[Double.Request], Double.Response]:
    """A callback that notes each number that it is asked for."""

    def answer(request: Double.Request) -> Double.Response:
        heard.append(request.number)
        return double(request)

    return answer


def fails(doing: Callable[[], object]) -> ServiceError:
    with pytest.raises(ServiceError) as caught:
        doing()
    assert "\n" not in str(caught.value)
    return caught.value


# The callback.


def test_a_callback_of_one_parameter_gets_the_request(backend: LocalBackend) -> None:
    backend.create_service(Double, "double", double)
    assert ask(backend, "double", 21) == 42


def test_a_callback_of_two_parameters_gets_a_new_response_too(backend: LocalBackend) -> None:
    given: list[Double.Response] = []

    def answer(request: Double.Request, response: Double.Response) -> Double.Response:
        given.append(response)
        response.texts.append("kept")
        return response

    backend.create_service(Double, "double", answer)
    ask(backend, "double")
    ask(backend, "double")
    assert [response.texts for response in given] == [["kept"], ["kept"]]


def test_a_parameter_with_a_default_is_the_programs_own(backend: LocalBackend) -> None:
    for factor in (2, 3):
        backend.create_service(
            Double,
            f"times_{factor}",
            lambda request, factor=factor: Double.Response(factor * request.number),
        )
    assert [ask(backend, f"times_{factor}", 7) for factor in (2, 3)] == [14, 21]


def test_a_decorated_callback_gets_both_as_from_rclpy(backend: LocalBackend) -> None:
    given: list[tuple[type, ...]] = []

    def answer(*arguments: Any) -> Double.Response:
        given.append(tuple(map(type, arguments)))
        return double(arguments[0])

    backend.create_service(Double, "double", answer)
    assert ask(backend, "double", 21) == 42
    assert given == [(Double.Request, Double.Response)]


def test_a_response_that_cannot_be_made_without_arguments_is_none(backend: LocalBackend) -> None:
    def answer(_: Other.Request, response: Other.Response) -> Other.Response:
        return Other.Response(repr(response))

    backend.create_service(Other, "other", answer)
    assert backend.create_client(Other, "other").call(Other.Request()).text == "None"


def test_a_callback_that_returns_something_else_has_failed(
    backend: LocalBackend, caplog: pytest.LogCaptureFixture
) -> None:
    backend.create_service(Double, "double", lambda request: 42)  # type: ignore[arg-type]  # the mistake is the test
    error = fails(lambda: ask(backend, "double"))
    assert isinstance(error, ServiceFailedError)
    assert "the callback of /double returned int, not Double.Response" in str(error)
    assert str(error) in caplog.text


@pytest.mark.parametrize("kind", [int, "Double", None])
def test_a_type_without_request_and_response_is_an_error(backend: LocalBackend, kind: Any) -> None:
    creates: tuple[Callable[[], object], ...] = (
        lambda: backend.create_service(kind, "x", double),
        lambda: backend.create_client(kind, "x"),
    )
    for create in creates:
        with pytest.raises(BackendError, match="'x' takes a class with Request and Response"):
            create()


def test_a_node_refuses_a_callback_that_would_never_run(backend: LocalBackend) -> None:
    async def late(request: Double.Request) -> Double.Response:
        return Double.Response()

    node = BaseNode(backend=backend)
    with pytest.raises(TypeError, match=r"the service double: .* is async"):
        node.create_service(Double, "double", late)  # type: ignore[arg-type]  # the mistake is the test


# Names and types.


def test_names_are_resolved_as_those_of_topics(backend: LocalBackend) -> None:
    names = {"a": "/a", "/b/c": "/b/c", "~/d": "/test/d"}
    for name, full in names.items():
        assert backend.create_service(Double, name, double).service_name == full
        assert backend.create_client(Double, name).service_name == full
    with pytest.raises(BackendError, match="'a b' is not a service name"):
        backend.create_client(Double, "a b")


def test_a_private_name_of_a_lifecycle_node_has_its_own_name(backend: LocalBackend) -> None:
    node = backend.open_node("arm", is_lifecycle=True)
    plain = backend.open_node("leg", is_lifecycle=False)
    assert node.create_service(Double, "~/open", double).service_name == "/arm/open"
    assert plain.create_service(Double, "~/open", double).service_name == "/test/open"
    assert node.create_client(Double, "~/open").service_name == "/arm/open"


def test_another_type_of_the_same_name_is_an_error(backend: LocalBackend) -> None:
    service = backend.create_service(Double, "double", double)
    text = "service /double is of type Double, so it cannot be of type Other"
    with pytest.raises(BackendError, match=text):
        backend.create_client(Other, "double")
    backend.destroy_service(service)
    backend.create_client(Other, "double")


def test_a_second_service_of_a_name_is_an_error(backend: LocalBackend) -> None:
    backend.create_service(Double, "double", double)
    with pytest.raises(BackendError, match="there is a service /double in this process already"):
        backend.create_service(Double, "double", double)


def test_a_request_of_another_class_is_an_error_that_names_both(backend: LocalBackend) -> None:
    client = backend.create_client(Double, "double")
    for call in (client.call, client.call_async):
        with pytest.raises(TypeError, match=r"/double takes Double.Request, not str"):
            call("five")  # type: ignore[arg-type]  # the mistake is the test


@pytest.mark.parametrize("wrong", [-1.0, float("nan"), None, "1"])
def test_a_timeout_that_is_no_duration_is_an_error(backend: LocalBackend, wrong: Any) -> None:
    client = backend.create_client(Double, "double")
    for wait in (
        lambda: client.call(Double.Request(), wrong),
        lambda: client.call_async(Double.Request(), wrong),
        lambda: client.wait_for_service(wrong),
    ):
        with pytest.raises(ValueError, match="seconds from 0 up"):
            wait()


# What can be changed.


@attrs.define
class Pad:
    texts: list[str] = attrs.field(factory=list)


class Write:
    """A type of requests and answers that can be changed, as those of ROS."""

    Request, Response = Pad, Pad


def test_one_request_that_is_changed_after_each_call_arrives_as_it_was_each_time(
    backend: LocalBackend,
) -> None:
    got: list[list[str]] = []

    def answer(request: Pad) -> Pad:
        got.append(request.texts)
        return Pad()

    client = backend.create_client(Write, "write")
    request = Pad()
    # The first three wait for the service, the others for the thread that spins.
    for text in "abcdef":
        if text == "d":
            backend.create_service(Write, "write", answer)
        request.texts.append(text)
        future = client.call_async(request)
    backend.spin_until(backend.clock.monotonic_ns() + 1_000_000_000, future.done)
    assert ["".join(texts) for texts in got] == ["a", "ab", "abc", "abcd", "abcde", "abcdef"]


def test_one_response_that_a_service_fills_again_is_another_for_each_caller(
    backend: LocalBackend,
) -> None:
    kept = Pad()

    def answer(request: Pad) -> Pad:
        kept.texts += request.texts
        return kept

    backend.create_service(Write, "write", answer)
    client = backend.create_client(Write, "write")
    answers = [client.call(Pad([text])) for text in "ab"]
    assert [one.texts for one in answers] == [["a"], ["a", "b"]]
    answers[1].texts.clear()
    assert kept.texts == ["a", "b"]


def test_a_frozen_request_is_not_copied(backend: LocalBackend) -> None:
    got: list[Double.Request] = []

    def answer(request: Double.Request) -> Double.Response:
        got.append(request)
        return double(request)

    backend.create_service(Double, "double", answer)
    request = Double.Request(3)
    backend.create_client(Double, "double").call(request)
    assert got[0] is request


def test_a_request_that_cannot_be_copied_is_an_error_of_its_caller(backend: LocalBackend) -> None:
    backend.create_service(Write, "write", lambda request: request)
    client = backend.create_client(Write, "write")
    lock: Any = threading.Lock()
    wrong = Pad([lock])
    for call in (client.call, client.call_async):
        with pytest.raises(TypeError, match="cannot pickle"):
            call(wrong)


# Failures.


def test_an_absent_service_is_an_error_at_its_timeout_in_virtual_time(
    backend: LocalBackend,
) -> None:
    error = fails(lambda: ask(backend, "double", timeout_s=3.0))
    assert isinstance(error, ServiceTimeoutError)
    assert str(error) == "/double: no such service after 3 s"
    assert backend.clock.monotonic_ns() == 3_000_000_000


def test_a_slow_service_is_an_error_at_its_timeout_and_its_answer_is_counted(
    pair: tuple[LocalBackend, LocalBackend],
) -> None:
    here, there = pair
    may_answer = threading.Event()

    def answer(request: Double.Request) -> Double.Response:
        may_answer.wait(20.0)
        return double(request)

    there.create_service(Double, "double", answer)
    client = here.create_client(Double, "double")
    with spun(there):
        error = fails(lambda: client.call(Double.Request(), timeout_s=0.05))
        assert isinstance(error, ServiceTimeoutError)
        assert str(error) == "/double: no answer after 0.05 s"
        assert client.dropped == 0
        may_answer.set()
        wait_until(lambda: client.dropped == 1, "the late answer")
        assert client.call(Double.Request(4)).number == 8


def slow(backend: LocalBackend, takes_s: float) -> Callable[[Double.Request], Double.Response]:
    """A callback that takes some virtual time."""

    def answer(request: Double.Request) -> Double.Response:
        backend.clock.sleep(takes_s)
        return double(request)

    return answer


@pytest.mark.parametrize("takes_s", [0.5, 0.100001])
def test_a_service_of_the_same_program_that_takes_longer_than_the_timeout_is_an_error(
    backend: LocalBackend, takes_s: float
) -> None:
    backend.create_service(Double, "double", slow(backend, takes_s))
    client = backend.create_client(Double, "double")
    error = fails(lambda: client.call(Double.Request(1), timeout_s=0.1))
    assert isinstance(error, ServiceTimeoutError)
    assert str(error) == "/double: no answer after 0.1 s"
    assert client.dropped == 1
    assert client.call(Double.Request(1), timeout_s=takes_s).number == 2


def test_an_answer_within_another_wait_is_late_as_well(backend: LocalBackend) -> None:
    backend.create_service(Double, "double", slow(backend, 0.5))
    client = backend.create_client(Double, "double")
    future = client.call_async(Double.Request(1), timeout_s=0.05)
    # No timer runs meanwhile.
    fails(lambda: ask(backend, "absent", timeout_s=1.0))
    assert isinstance(future.exception(), ServiceTimeoutError)
    assert client.dropped == 1


def test_a_failure_after_the_timeout_is_a_timeout(backend: LocalBackend) -> None:
    def answer(request: Double.Request) -> Double.Response:
        backend.clock.sleep(0.5)
        raise ArithmeticError

    backend.create_service(Double, "double", answer)
    assert isinstance(fails(lambda: ask(backend, "double", timeout_s=0.1)), ServiceTimeoutError)


def test_an_answer_after_the_time_of_the_outer_call_is_late(backend: LocalBackend) -> None:
    backend.create_service(Double, "slow", slow(backend, 0.5))
    seen: list[ServiceError] = []

    def answer(request: Double.Request) -> Double.Response:
        seen.append(fails(lambda: ask(backend, "slow", timeout_s=5.0)))
        return double(request)

    backend.create_service(Double, "outer", answer)
    assert isinstance(fails(lambda: ask(backend, "outer", timeout_s=0.1)), ServiceTimeoutError)
    text = "no answer after 0.1 s, all that was left of the call that waits for this one"
    assert [str(error) for error in seen] == [f"/slow: {text}"]


def test_a_service_that_raises_is_an_error_for_the_caller_and_in_the_log(
    backend: LocalBackend, caplog: pytest.LogCaptureFixture
) -> None:
    def answer(request: Double.Request) -> Double.Response:
        raise ValueError("no\nfingers")

    backend.create_service(Double, "double", answer)
    error = fails(lambda: ask(backend, "double"))
    assert isinstance(error, ServiceFailedError)
    assert str(error) == "/double failed: ValueError: no fingers"
    assert error.reason == "ValueError: no fingers"
    assert isinstance(error.__cause__, ValueError)
    (record,) = caplog.records
    assert record.exc_text
    assert "fingers" in record.exc_text


def test_a_service_that_fails_because_another_one_did_has_its_reason_once(
    backend: LocalBackend, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(request: Double.Request) -> Double.Response:
        raise ValueError("no fingers")

    backend.create_service(Double, "inner", fail)
    backend.create_service(Double, "outer", lambda request: Double.Response(ask(backend, "inner")))
    assert str(fails(lambda: ask(backend, "outer"))) == "/outer failed: ValueError: no fingers"
    assert [record.getMessage() for record in caplog.records] == [
        "/inner failed: ValueError: no fingers"
    ]


def test_what_ends_the_program_passes_through_a_service(backend: LocalBackend) -> None:
    def answer(request: Double.Request) -> Double.Response:
        raise SystemExit(3)

    backend.create_service(Double, "double", answer)
    client = backend.create_client(Double, "double")
    future = client.call_async(Double.Request())
    with pytest.raises(SystemExit):
        backend.spin_once(0.0)
    assert str(future.exception()) == "/double failed: it was interrupted"


@pytest.mark.parametrize("how", ["destroyed", "closed"])
def test_a_service_that_goes_away_is_an_error_at_once(
    pair: tuple[LocalBackend, LocalBackend], how: str
) -> None:
    here, there = pair
    service = there.create_service(Double, "double", double)
    # Nobody spins it, so the requests wait.
    futures = [here.create_client(Double, "double").call_async(Double.Request()) for _ in range(3)]
    if how == "closed":
        there.close()
    else:
        there.destroy_service(service)
    for future in futures:
        error = fails(future.result)
        assert isinstance(error, ServiceFailedError)
        assert str(error) == "/double failed: it went away before it answered"
    assert not here.create_client(Double, "double").service_is_ready()


def test_a_request_waits_for_a_service_that_comes_within_the_timeout(
    backend: LocalBackend,
) -> None:
    future = backend.create_client(Double, "double").call_async(Double.Request(4))
    backend.spin_once(1.0)
    backend.create_service(Double, "double", double)
    backend.spin_once(0.0)
    assert future.result().number == 8


def test_requests_that_wait_for_a_service_are_limited(backend: LocalBackend) -> None:
    backend.create_service(Double, "double", double)
    client = backend.create_client(Double, "double")
    futures = [client.call_async(Double.Request()) for _ in range(1001)]
    assert str(futures[-1].exception()) == "/double failed: 1000 requests wait for it already"
    backend.spin_until(backend.clock.monotonic_ns() + 1_000_000_000, futures[-2].done)
    assert all(future.exception() is None for future in futures[:-1])


def test_ended_calls_to_an_absent_service_are_not_kept(backend: LocalBackend) -> None:
    client = backend.create_client(Double, "double")
    for _ in range(100):
        client.call_async(Double.Request(), timeout_s=0.1)
        backend.spin_once(0.2)
    assert len(backend._bus.services._services["/double"].waiting) <= 16
    # Behind one that never ends, too.
    client.call_async(Double.Request(), timeout_s=float("inf"))
    for _ in range(1000):
        client.call_async(Double.Request()).cancel()
    assert len(backend._bus.services._services["/double"].waiting) <= 32


def test_a_circle_of_services_is_an_error(backend: LocalBackend) -> None:
    depths: list[int] = []

    def answer(request: Double.Request) -> Double.Response:
        depths.append(backend.executor.depth)
        return Double.Response(ask(backend, "double"))

    backend.create_service(Double, "double", answer)
    error = fails(lambda: ask(backend, "double"))
    assert isinstance(error.__cause__, ServiceError)
    assert "/double: 16 calls wait already, each within another" in str(error)
    assert depths == list(range(1, 17))
    assert backend.executor.depth == 0


def test_a_wait_for_a_service_has_the_same_limit(backend: LocalBackend) -> None:
    client = backend.create_client(Double, "absent")
    seen: list[ServiceError] = []

    def answer(request: Double.Request) -> Double.Response:
        if backend.executor.depth == 16:
            seen.append(fails(client.wait_for_service))
            return Double.Response()
        return Double.Response(ask(backend, "double"))

    backend.create_service(Double, "double", answer)
    ask(backend, "double")
    assert [type(error) for error in seen] == [ServiceDepthError]


# Waiting.


def test_ticks_timers_and_messages_wait_while_a_call_does(backend: LocalBackend) -> None:
    heard: list[Any] = []
    publisher = backend.create_publisher(String, "said", 10)
    backend.create_subscription(String, "said", lambda message: heard.append(message.data), 10)
    backend.create_timer(0.1, lambda: heard.append("timer"))
    backend.create_service(Double, "double", noting(heard))
    publisher.publish(String("message"))
    backend.call_soon(lambda: heard.append("call"))
    backend.create_client(Double, "double").call_async(Double.Request(5))
    fails(lambda: ask(backend, "absent", timeout_s=1.0))
    assert heard == [5]
    backend.spin_until(backend.clock.monotonic_ns(), lambda: False)
    assert sorted(heard[1:]) == ["call", "message", "timer"]


def test_requests_take_their_turn_among_other_calls_of_a_loop(backend: LocalBackend) -> None:
    heard: list[Any] = []
    backend.create_service(Double, "double", noting(heard))
    client = backend.create_client(Double, "double")
    for number in range(3):
        client.call_async(Double.Request(number))
        backend.call_soon(partial(heard.append, "call"))
    backend.spin_until(backend.clock.monotonic_ns(), lambda: False)
    assert heard == [0, "call", 1, "call", 2, "call"]


def test_a_service_may_call_another_one_of_the_same_backend(backend: LocalBackend) -> None:
    backend.create_service(Double, "double", double)

    def answer(request: Double.Request) -> Double.Response:
        return Double.Response(ask(backend, "double", ask(backend, "double", request.number)))

    backend.create_service(Double, "quadruple", answer)
    assert ask(backend, "quadruple", 3) == 12


def test_a_call_within_a_call_has_at_most_the_time_that_is_left(backend: LocalBackend) -> None:
    seen: list[ServiceError] = []

    def answer(request: Double.Request) -> Double.Response:
        seen.append(fails(lambda: ask(backend, "absent", timeout_s=100.0)))
        return double(request)

    backend.create_service(Double, "double", answer)
    assert ask(backend, "double", 1, timeout_s=2.0) == 2
    assert backend.clock.monotonic_ns() == 2_000_000_000
    text = "no such service after 2 s, all that was left of the call that waits for this one"
    assert str(seen[0]) == f"/absent: {text}"


def test_two_that_call_each_other_at_the_same_time_both_get_answers(
    pair: tuple[LocalBackend, LocalBackend],
) -> None:
    together = threading.Barrier(2)
    answers: dict[str, list[int]] = {"one": [], "two": []}

    def work(backend: LocalBackend, other: str) -> None:
        client = backend.create_client(Double, f"{other}/double")
        together.wait(20.0)
        for number in range(200):
            answers[backend.node_name].append(client.call(Double.Request(number)).number)

    for backend in pair:
        backend.create_service(Double, "~/double", double)
    with spun(*pair):
        for backend, other in zip(pair, ("two", "one"), strict=True):
            backend.call_soon(partial(work, backend, other))
        wait_until(lambda: all(len(got) == 200 for got in answers.values()), "the answers")
    assert answers["one"] == answers["two"] == [2 * number for number in range(200)]


def test_any_thread_may_call(pair: tuple[LocalBackend, LocalBackend]) -> None:
    there = pair[1]
    there.create_service(Double, "double", double)
    clients = [one.create_client(Double, "double") for one in pair]
    got: list[int] = []

    def work(first: int) -> None:
        for number in range(first, first + 50):
            got.append(clients[first % 100 // 50].call(Double.Request(number)).number)

    with spun(there):
        threads = [threading.Thread(target=work, args=(50 * n,)) for n in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(20.0)
    assert sorted(got) == [2 * number for number in range(200)]


def test_another_thread_gets_its_answer_in_virtual_time_too() -> None:
    backend = virtual_backend()
    backend.create_service(Double, "double", double)
    got: list[int] = []
    thread = threading.Thread(target=lambda: got.append(ask(backend, "double", 4)))
    thread.start()
    while thread.is_alive():
        # Somebody who reads the clock more than that would find that it stands still.
        backend.clock.sleep(1e-6)
        backend.spin_once(0.0)
    backend.close()
    assert got == [8]


def test_wait_for_service_says_whether_it_is_there(
    pair: tuple[LocalBackend, LocalBackend],
) -> None:
    here, there = pair
    client = here.create_client(Double, "double")
    assert not client.wait_for_service(timeout_s=0.05)
    assert not client.wait_for_service(timeout_s=0.0)
    with spun(there):
        there.call_soon(lambda: there.create_service(Double, "double", double))
        assert client.wait_for_service()
    assert client.wait_for_service(timeout_s=0.0)


def test_wait_for_service_within_a_call_ends_with_it(backend: LocalBackend) -> None:
    client = backend.create_client(Double, "absent")
    backend.create_service(
        Double, "double", lambda request: Double.Response(client.wait_for_service(9))
    )
    assert ask(backend, "double", timeout_s=1.0) == 0
    assert backend.clock.monotonic_ns() == 1_000_000_000


def test_a_wait_for_a_service_leaves_the_services_that_run_meanwhile_all_of_its_time(
    backend: LocalBackend,
) -> None:
    seen: list[ServiceError] = []

    def answer(request: Double.Request) -> Double.Response:
        seen.append(fails(lambda: ask(backend, "absent", timeout_s=100.0)))
        return double(request)

    backend.create_service(Double, "double", answer)
    client = backend.create_client(Double, "double")
    client.call_async(Double.Request(), timeout_s=50.0)
    assert not backend.create_client(Double, "other").wait_for_service(timeout_s=2.0)
    text = "no such service after 2 s, all that was left of the call that waits for this one"
    assert [str(error) for error in seen] == [f"/absent: {text}"]


def test_a_wait_for_a_service_ends_when_its_client_does(
    pair: tuple[LocalBackend, LocalBackend],
) -> None:
    here, there = pair
    client, errors = here.create_client(Double, "absent"), list[ServiceError]()
    there.create_service(Double, "double", double)
    with spun(here):
        waits = threading.Event()

        def wait() -> None:
            waits.set()
            errors.append(fails(lambda: client.wait_for_service(timeout_s=100.0)))

        thread = threading.Thread(target=wait)
        thread.start()
        waits.wait(20.0)
        here.destroy_client(client)
        thread.join(20.0)
    assert [str(error) for error in errors] == ["/absent: the client has been destroyed"]


# Futures.


def test_the_callbacks_of_a_future_run_on_the_main_loop(
    pair: tuple[LocalBackend, LocalBackend],
) -> None:
    here, there = pair
    there.create_service(Double, "double", double)
    got: list[tuple[int, int]] = []
    client = here.create_client(Double, "double")
    future = client.call_async(Double.Request(4))
    future.add_done_callback(lambda done: got.append((done.result().number, threading.get_ident())))
    with pytest.raises(ServiceError, match="the answer is not there yet"):
        future.result()
    with spun(there):
        wait_until(future.done, "the answer")
    assert not got
    here.spin_once(0.0)
    assert got == [(8, threading.get_ident())]
    future.add_done_callback(lambda done: got.append((0, threading.get_ident())))
    assert len(got) == 1
    here.spin_once(0.0)
    assert len(got) == 2


def test_a_future_fails_at_its_timeout(backend: LocalBackend) -> None:
    future = backend.create_client(Double, "double").call_async(Double.Request(), timeout_s=2.0)
    backend.spin_until(10_000_000_000, future.done)
    assert isinstance(future.exception(), ServiceTimeoutError)
    assert backend.clock.monotonic_ns() == 2_000_000_000
    assert not future.cancelled()


def test_an_answer_in_time_leaves_no_timer_behind(backend: LocalBackend) -> None:
    backend.create_service(Double, "double", double)
    client = backend.create_client(Double, "double")
    for _ in range(1000):
        future = client.call_async(Double.Request())
        backend.spin_once(0.0)
        assert future.result().number == 0
    assert len(backend.executor.timers) <= 64
    assert client.call_async(Double.Request(), timeout_s=float("inf")).exception() is None


def test_a_cancelled_call_is_not_answered_and_one_under_way_is_counted(
    pair: tuple[LocalBackend, LocalBackend],
) -> None:
    here, there = pair
    asked: list[int] = []
    client = here.create_client(Double, "double")

    def answer(request: Double.Request) -> Double.Response:
        asked.append(request.number)
        under_way.cancel()
        return double(request)

    there.create_service(Double, "double", answer)
    under_way = client.call_async(Double.Request(1))
    waiting = client.call_async(Double.Request(2))
    waiting.cancel()
    for _ in range(4):
        there.spin_once(0.0)
    assert asked == [1]
    assert client.dropped == 1
    for future in (under_way, waiting):
        assert future.cancelled()
        assert str(fails(future.result)) == "/double: the call was cancelled"
    done = client.call_async(Double.Request(3))
    there.spin_once(0.0)
    done.cancel()
    assert done.result().number == 6
    assert not done.cancelled()


# The end.


def test_a_destroyed_client_ends_its_calls(backend: LocalBackend) -> None:
    client = backend.create_client(Double, "double")
    future = client.call_async(Double.Request())
    for _ in range(2):
        backend.destroy_client(client)
    for call in (future.result, lambda: client.call(Double.Request())):
        assert str(fails(call)) == "/double: the client has been destroyed"


def test_calls_of_a_destroyed_client_end_in_the_order_of_their_begin(
    backend: LocalBackend,
) -> None:
    client = backend.create_client(Double, "absent")
    # So many that no order of addresses is the same by chance.
    calls = [client.call_async(Double.Request(n)) for n in range(50)]
    ended: list[Any] = []
    for call in calls:
        call.add_done_callback(ended.append)
    backend.destroy_client(client)
    for _ in calls:
        backend.spin_once(0)
    assert ended == calls


def test_no_service_is_ready_for_a_destroyed_client(backend: LocalBackend) -> None:
    backend.create_service(Double, "double", double)
    client = backend.create_client(Double, "double")
    assert client.service_is_ready()
    backend.destroy_client(client)
    assert not client.service_is_ready()
    assert str(fails(client.wait_for_service)) == "/double: the client has been destroyed"


def test_closing_ends_the_wait_of_another_thread(backend: LocalBackend) -> None:
    errors: list[ServiceError] = []
    client = backend.create_client(Double, "double")
    call = partial(client.call, Double.Request(), 1000.0)
    thread = threading.Thread(target=lambda: errors.append(fails(call)))
    thread.start()
    wait_until(lambda: client._pending, "the call")  # type: ignore[attr-defined]  # rosbase's own kind of client
    backend.close()
    thread.join(20.0)
    assert [str(error) for error in errors] == ["/double: the client has been destroyed"]
    assert not backend._bus.services._services


def test_a_closed_backend_creates_nothing(backend: LocalBackend) -> None:
    service = backend.create_service(Double, "double", double)
    backend.close()
    backend.destroy_service(service)
    creates: tuple[Callable[[], object], ...] = (
        lambda: backend.create_service(Double, "double", double),
        lambda: backend.create_client(Double, "double"),
    )
    for create in creates:
        with pytest.raises(BackendError, match="the backend is closed"):
            create()


def test_a_lifecycle_node_answers_in_every_state(backend: LocalBackend) -> None:
    node = LifecycleNode(backend=backend)
    service = node.create_service(Double, "~/double", double)
    client = node.create_client(Double, "~/double")
    assert client.call(Double.Request(2)).number == 4
    node.trigger_configure()
    assert client.call(Double.Request(2)).number == 4
    node.destroy_service(service)
    node.destroy_client(client)
    assert fails(lambda: client.call(Double.Request()))


def test_a_backend_without_services_says_so() -> None:
    class Bare(LocalBackend):
        create_service = Backend.create_service
        create_client = Backend.create_client
        destroy_service = Backend.destroy_service
        destroy_client = Backend.destroy_client

    bare = Bare(BackendOptions("bare"), Bus())
    creates: tuple[Callable[[], object], ...] = (
        lambda: bare.create_service(Double, "double", double),
        lambda: bare.create_client(Double, "double"),
    )
    for create in creates:
        with pytest.raises(BackendError, match="double: this backend has no services"):
            create()
    bare.destroy_service(None)  # type: ignore[arg-type]  # the mistake is the test
    bare.destroy_client(None)  # type: ignore[arg-type]  # the mistake is the test
    bare.close()
