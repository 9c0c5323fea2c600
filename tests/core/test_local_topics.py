import threading
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.backend import BackendOptions
from rosbase.errors import BackendError, ParameterError
from rosbase.local import Bus, LocalBackend
from rosbase.messages import Header, Time
from rosbase.parameters import ParameterSpec
from rosbase.testing import ManualClock


def make(bus: Bus | None = None, **options: object) -> LocalBackend:
    return LocalBackend(BackendOptions("robot", **options), bus or Bus())  # type: ignore[arg-type]


@pytest.fixture
def backend() -> Iterator[LocalBackend]:
    backend = make(clock=ManualClock())
    yield backend
    backend.close()


def drain(backend: LocalBackend) -> None:
    while backend.spin_once(0.0):
        pass


def message(number: int) -> Header:
    return Header(Time(number))


def test_a_message_reaches_every_subscription_as_it_is(backend: LocalBackend) -> None:
    got: list[Header] = []
    backend.create_subscription(Header, "scan", got.append, 10)
    backend.create_subscription(Header, "/scan", got.append, 10)
    sent = message(1)
    backend.create_publisher(Header, "scan", 10).publish(sent)
    assert got == []
    drain(backend)
    assert len(got) == 2
    assert all(received is sent for received in got)


@given(st.integers(1, 20), st.integers(0, 50))
def test_a_subscription_keeps_the_last_ones_and_counts_the_others(depth: int, sent: int) -> None:
    backend = make()
    got: list[Header] = []
    subscription = backend.create_subscription(Header, "scan", got.append, depth)
    publisher = backend.create_publisher(Header, "scan", 1)
    for number in range(sent):
        publisher.publish(message(number))
    drain(backend)
    assert [header.stamp.sec for header in got] == list(range(sent))[-depth:]
    assert subscription.dropped == max(0, sent - depth)
    backend.close()


def test_publishing_is_allowed_from_any_thread_and_loses_nothing() -> None:
    backend = make()
    got: list[int] = []
    subscription = backend.create_subscription(
        Header, "scan", lambda header: got.append(header.stamp.sec), 4000
    )

    def publish(first: int) -> None:
        publisher = backend.create_publisher(Header, "scan", 1)
        for number in range(first, first + 1000):
            publisher.publish(message(number))

    threads = [threading.Thread(target=publish, args=(n * 1000,)) for n in range(4)]
    for thread in threads:
        thread.start()
    while len(got) < 4000:
        assert backend.spin_once(5.0), "a message was lost"
    for thread in threads:
        thread.join()
    assert sorted(got) == list(range(4000))
    for first in range(0, 4000, 1000):
        own = [number for number in got if first <= number < first + 1000]
        assert own == sorted(own), "messages of one publisher must stay in order"
    assert subscription.dropped == 0
    backend.close()


def test_a_waiting_spinner_is_woken_by_a_message_from_another_thread() -> None:
    backend = make()
    got: list[Header] = []
    backend.create_subscription(Header, "scan", got.append, 1)
    publisher = backend.create_publisher(Header, "scan", 1)
    thread = threading.Thread(target=lambda: publisher.publish(message(1)))
    thread.start()
    assert backend.spin_once(30.0)
    thread.join()
    assert len(got) == 1
    backend.close()


def test_a_topic_has_one_type(backend: LocalBackend) -> None:
    backend.create_publisher(Header, "scan", 1)
    with pytest.raises(BackendError, match="/scan carries Header, so it cannot carry Time"):
        backend.create_subscription(Time, "scan", print, 1)


def test_a_topic_is_forgotten_with_its_last_user(backend: LocalBackend) -> None:
    publisher = backend.create_publisher(Header, "scan", 1)
    backend.destroy_publisher(publisher)
    backend.destroy_publisher(publisher)
    backend.create_publisher(Time, "scan", 1)


def test_a_message_of_another_type_is_refused(backend: LocalBackend) -> None:
    publisher = backend.create_publisher(Header, "scan", 1)
    with pytest.raises(TypeError, match="/scan takes Header, not Time"):
        publisher.publish(Time())


@pytest.mark.parametrize("topic", ["", "/", "a//b", "1a", "a b", "a/", "a.b", 5, "ä"])
def test_what_is_not_a_topic_name_is_refused(backend: LocalBackend, topic: str) -> None:
    with pytest.raises(BackendError, match="topic name"):
        backend.create_publisher(Header, topic, 1)


@pytest.mark.parametrize("depth", [0, -1, True, 1.5, None])
def test_what_is_not_a_depth_is_refused(backend: LocalBackend, depth: int) -> None:
    with pytest.raises(BackendError, match="depth"):
        backend.create_subscription(Header, "scan", print, depth)


def test_private_names_stand_under_the_node(backend: LocalBackend) -> None:
    assert backend.create_publisher(Header, "~/status", 1).topic == "/robot/status"


def test_nothing_is_called_back_after_destroy(backend: LocalBackend) -> None:
    got: list[Header] = []
    subscription = backend.create_subscription(Header, "scan", got.append, 1)
    backend.create_publisher(Header, "scan", 1).publish(message(1))
    backend.destroy_subscription(subscription)
    backend.destroy_subscription(subscription)
    drain(backend)
    assert got == []


def test_backends_of_one_process_share_their_topics() -> None:
    one = LocalBackend(BackendOptions("one"))
    two = LocalBackend(BackendOptions("two"))
    got: list[Header] = []
    one.create_subscription(Header, "shared_by_test", got.append, 1)
    two.create_publisher(Header, "shared_by_test", 1).publish(message(1))
    drain(one)
    assert len(got) == 1
    one.close()
    two.close()


def test_a_closed_backend_refuses_and_closes_again(backend: LocalBackend) -> None:
    publisher = backend.create_publisher(Header, "scan", 1)
    backend.close()
    backend.close()
    with pytest.raises(BackendError, match="closed"):
        backend.create_publisher(Header, "scan", 1)
    with pytest.raises(BackendError, match="destroyed"):
        publisher.publish(message(1))


def test_what_a_callback_raises_is_raised_to_the_spinner(backend: LocalBackend) -> None:
    backend.call_soon(lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        backend.spin_once(0.0)


def test_parameters_take_their_override_and_are_checked() -> None:
    backend = make(parameter_overrides={"rate": 5, "name": 7})
    assert backend.declare_parameter(ParameterSpec("rate", 1.0)).value == 5.0
    assert backend.declare_parameter(ParameterSpec("other", default=True)).value is True
    assert backend.get_parameter("rate").value == 5.0
    with pytest.raises(ParameterError, match="name takes text"):
        backend.declare_parameter(ParameterSpec("name", "x"))
    with pytest.raises(ParameterError, match="twice"):
        backend.declare_parameter(ParameterSpec("rate", 1.0))
    with pytest.raises(ParameterError, match="not been declared"):
        backend.get_parameter("nothing")
    backend.close()
