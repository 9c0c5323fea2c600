"""Publishers, subscriptions, services and clients of the backend `local` in a recorded program."""

import threading
from typing import Any

import pytest
from attrs import frozen

from rosbase.contracts.backend import BackendOptions
from rosbase.contracts.service_server import ServiceServer
from rosbase.entries.kinds import Kind
from rosbase.errors import ServiceFailedError
from rosbase.local import LocalBackend
from rosbase.local.endpoints import LocalPublisher, LocalSubscription
from rosbase.messages import Vector3
from rosbase.messages.fields import Float32, message
from rosbase.messages.rcl_interfaces import GetParameters
from rosbase.messages.std_srvs import SetBool
from rosbase.parameters import Parameter, ParameterSpec
from rosbase.qos import DurabilityPolicy, QoSProfile
from rosbase.testing import ManualClock, virtual_backend
from support.conducted import ConductedProgram, record, replay
from support.waiting import wait_until

LATCHED = QoSProfile(3, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@message("tests_msgs/msg/Small")
@frozen
class Small:
    """Has less room than a number of Python."""

    value: Float32 = 0.0


@frozen
class Unknown:
    """Has no schema."""

    value: int = 0


def neighbour(program: ConductedProgram) -> LocalBackend:
    """Return a backend of the same process that nobody records."""
    return LocalBackend(BackendOptions("neighbour", clock=ManualClock()), program.bus)


def test_what_another_thread_publishes_comes_again() -> None:
    def run(program: ConductedProgram) -> None:
        backend = program.backend
        publisher = backend.create_publisher(Vector3, "speed", 10)
        backend.create_subscription(Vector3, "speed", program.see, 10)
        publisher.publish(Vector3(x=1.0))
        program.outside(lambda: publisher.publish(Vector3(x=2.0)))
        publisher.publish(Vector3(x=3.0))
        program.spin()

    recorded = record(run)
    assert recorded.seen == [(Vector3(x=x),) for x in (1.0, 3.0, 2.0)]
    assert recorded.kinds.count(Kind.PUBLISH) == 1
    assert recorded.spoiled == []
    assert replay(run, recorded) == recorded.seen


def test_a_full_queue_keeps_the_last_messages_and_counts_the_others_again() -> None:
    def run(program: ConductedProgram) -> None:
        publisher = program.backend.create_publisher(Vector3, "speed", 10)
        subscription = program.backend.create_subscription(Vector3, "speed", program.see, 2)
        for number in range(5):
            publisher.publish(Vector3(x=float(number)))
        program.see(subscription.dropped)
        program.spin()

    recorded = record(run)
    assert recorded.seen == [(3,), (Vector3(x=3.0),), (Vector3(x=4.0),)]
    assert replay(run, recorded) == recorded.seen


def test_a_destroyed_subscription_hears_nothing_of_what_waits_again() -> None:
    def run(program: ConductedProgram) -> None:
        publisher = program.backend.create_publisher(Vector3, "speed", 10)
        subscription = program.backend.create_subscription(Vector3, "speed", program.see, 10)
        publisher.publish(Vector3())
        program.backend.destroy_subscription(subscription)
        publisher.publish(Vector3())
        program.spin()

    recorded = record(run)
    assert recorded.seen == []
    assert replay(run, recorded) == []


def test_a_latched_message_of_another_thread_is_kept_again() -> None:
    def run(program: ConductedProgram) -> None:
        publisher = program.backend.create_publisher(Vector3, "speed", LATCHED)
        program.outside_once(lambda: publisher.publish(Vector3(x=2.0)))
        program.spin()
        program.backend.create_subscription(Vector3, "speed", program.see, LATCHED)
        program.spin()

    recorded = record(run)
    assert recorded.seen == [(Vector3(x=2.0),)]
    assert replay(run, recorded) == recorded.seen


def test_a_message_of_another_backend_arrives_again() -> None:
    def run(program: ConductedProgram) -> None:
        program.backend.create_subscription(Vector3, "speed", program.see, 10)
        other = neighbour(program)
        publisher = other.create_publisher(Vector3, "speed", 10)
        program.outside_once(lambda: publisher.publish(Vector3(x=2.0)))
        program.spin()

    recorded = record(run)
    assert recorded.seen == [(Vector3(x=2.0),)]
    assert recorded.kinds.count(Kind.ARRIVE) == 1
    assert replay(run, recorded) == recorded.seen


def test_a_message_comes_in_as_its_bytes_have_it() -> None:
    def run(program: ConductedProgram) -> None:
        publisher = program.backend.create_publisher(Small, "small", 10)
        program.backend.create_subscription(Small, "small", program.see, 10)
        program.outside_once(lambda: publisher.publish(Small(0.1)))
        program.spin()

    recorded = record(run)
    assert recorded.seen == [(Small(0.10000000149011612),)]
    assert replay(run, recorded) == recorded.seen


def test_a_message_without_schema_spoils_the_recording_and_arrives() -> None:
    def run(program: ConductedProgram) -> None:
        publisher = program.backend.create_publisher(Unknown, "unknown", 10)
        program.backend.create_subscription(Unknown, "unknown", program.see, 10)
        program.outside(lambda: publisher.publish(Unknown(1)))
        program.spin()

    recorded = record(run)
    assert recorded.seen == [(Unknown(1),)]
    assert [line[:9] for line in recorded.spoiled] == ["/unknown:"]


def test_a_wrong_message_of_another_thread_is_refused_at_once() -> None:
    raised: list[str] = []

    def run(program: ConductedProgram) -> None:
        publisher: Any = program.backend.create_publisher(Vector3, "speed", 10)

        def publish() -> None:
            with pytest.raises(TypeError) as error:
                publisher.publish(Small())
            raised.append(str(error.value))

        program.outside_once(publish)

    recorded = record(run)
    assert raised == ["/speed takes Vector3, not Small"]
    assert Kind.PUBLISH not in recorded.kinds


def test_a_publisher_of_another_thread_spoils_the_recording() -> None:
    def run(program: ConductedProgram) -> None:
        backend = program.backend
        made: list[Any] = []
        program.outside(lambda: made.append(backend.create_publisher(Vector3, "speed", 10)))
        program.outside(lambda: backend.destroy_publisher(made[0]))

    assert record(run).spoiled == [
        "thread 'outside' created a publisher: /speed",
        "a thread of the program's own destroys a publisher",
    ]


def test_parameters_that_another_thread_sets_spoil_the_recording() -> None:
    def run(program: ConductedProgram) -> None:
        program.backend.declare_parameter(ParameterSpec("gain", 1.0))
        program.outside(lambda: program.backend.set_parameters([Parameter("gain", 2.0)]))

    assert record(run).spoiled == ["a thread of the program's own sets parameters"]


def serve(program: ConductedProgram, request: SetBool.Request) -> SetBool.Response:
    program.see("request", request.data, program.backend.clock.now_ns())
    if not request.data:
        raise ValueError("no")
    return SetBool.Response(success=True, message="yes")


def test_a_request_of_another_backend_is_answered_again() -> None:
    answers: list[Any] = []

    def run(program: ConductedProgram) -> None:
        program.backend.create_service(SetBool, "switch", lambda r: serve(program, r))
        client = neighbour(program).create_client(SetBool, "switch")
        program.outside_once(lambda: answers.append(client.call_async(SetBool.Request(True))))
        program.spin()

    recorded = record(run)
    assert answers[0].result() == SetBool.Response(success=True, message="yes")
    assert recorded.kinds.count(Kind.REQUEST) == 1
    assert recorded.spoiled == []
    assert replay(run, recorded) == recorded.seen
    assert recorded.seen[0][1] is True


@pytest.mark.parametrize("data", [True, False])
def test_the_answer_of_another_backend_comes_again(data: bool) -> None:
    def run(program: ConductedProgram) -> None:
        client = program.backend.create_client(SetBool, "switch")
        if not program.conductor.is_replay:
            other = neighbour(program)
            other.create_service(SetBool, "switch", serve_alone)
        program.see("ready", client.service_is_ready())
        future = client.call_async(SetBool.Request(data))
        future.add_done_callback(lambda one: program.see(text_of(one)))
        program.outside_once(lambda: other.spin_once(0))
        program.spin()

    recorded = record(run)
    assert recorded.seen[0] == ("ready", True)
    assert recorded.seen[1] == ("yes" if data else "/switch failed: ValueError: no",)
    assert recorded.kinds.count(Kind.ANSWER) == 1
    assert replay(run, recorded) == recorded.seen


def serve_alone(request: SetBool.Request) -> SetBool.Response:
    if not request.data:
        raise ValueError("no")
    return SetBool.Response(success=True, message="yes")


def text_of(future: Any) -> str:
    error = future.exception()
    if isinstance(error, ServiceFailedError):
        assert error.reason == "ValueError: no"
    return str(error or future.result().message)


def test_an_answer_that_comes_too_late_is_counted_again() -> None:
    def run(program: ConductedProgram) -> None:
        client = program.backend.create_client(SetBool, "switch")
        other, late = neighbour(program), threading.Event()

        def serve_late(_: SetBool.Request) -> SetBool.Response:
            begun.set()
            late.wait()
            return SetBool.Response()

        begun = threading.Event()
        if not program.conductor.is_replay:
            other.create_service(SetBool, "switch", serve_late)
        future = client.call_async(SetBool.Request(True), 0.05)
        future.add_done_callback(lambda one: program.see(text_of(one)))
        serving = threading.Thread(target=other.spin_once, args=(0,))
        serving.start()
        assert program.conductor.is_replay or begun.wait(5)
        program.spin(0.1)
        late.set()
        serving.join()
        program.spin(0.1)
        program.see("dropped", client.dropped)

    recorded = record(run)
    assert recorded.seen == [("/switch: no answer after 0.05 s",), ("dropped", 1)]
    assert replay(run, recorded) == recorded.seen


def test_a_call_that_waits_has_its_answer_again() -> None:
    def run(program: ConductedProgram) -> None:
        program.backend.create_service(SetBool, "switch", lambda r: serve(program, r))
        client = program.backend.create_client(SetBool, "switch")
        program.see(client.call(SetBool.Request(True)))
        absent = program.backend.create_client(SetBool, "absent")
        program.see(absent.wait_for_service(0.2), program.backend.clock.monotonic_ns())

    recorded = record(run)
    assert replay(run, recorded) == recorded.seen


def test_a_call_of_another_thread_without_waiting_spoils_the_recording() -> None:
    def run(program: ConductedProgram) -> None:
        program.backend.create_service(SetBool, "switch", lambda r: serve(program, r))
        client = program.backend.create_client(SetBool, "switch")
        program.outside(lambda: client.call_async(SetBool.Request(True)))
        program.spin()

    assert record(run).spoiled[0] == (
        "/switch: a thread of the program calls it without waiting for the answer"
    )


def test_a_request_that_has_waited_for_the_service_spoils_the_recording() -> None:
    def run(program: ConductedProgram) -> None:
        client = program.backend.create_client(SetBool, "switch")
        calling = threading.Thread(target=lambda: client.call(SetBool.Request(True), 5.0))
        calling.start()
        wait_until(lambda: program.bus.services._services["/switch"].waiting, "the call")
        program.backend.create_service(SetBool, "switch", lambda r: serve(program, r))
        program.spin()
        program.conductor.aside(calling.join)

    recorded = record(run)
    assert recorded.spoiled == [
        "/switch: a thread of the program has called it before it was there"
    ]


def test_a_request_for_a_standard_service_is_answered_again() -> None:
    answers: list[Any] = []

    def run(program: ConductedProgram) -> None:
        program.backend.declare_parameter(ParameterSpec("gain", 1.5))
        client = neighbour(program).create_client(GetParameters, "robot/get_parameters")
        request = GetParameters.Request(("gain",))
        program.outside_once(lambda: answers.append(client.call_async(request)))
        program.spin()

    recorded = record(run)
    assert answers[0].result().values[0].double_value == 1.5
    assert recorded.kinds.count(Kind.REQUEST) == 1
    assert recorded.kinds.count(Kind.URGENT) + recorded.kinds.count(Kind.CALL) == 1
    assert replay(run, recorded) == recorded.seen


def test_without_a_recording_the_ends_are_the_plain_ones() -> None:
    backend = virtual_backend()
    assert type(backend.create_publisher(Vector3, "speed", 1)) is LocalPublisher
    assert type(backend.create_subscription(Vector3, "speed", print, 1)) is LocalSubscription
    assert type(backend.create_service(SetBool, "switch", serve_alone)) is ServiceServer
    client = backend.create_client(SetBool, "switch")
    call: Any = client.call_async(SetBool.Request(True))
    assert type(call).__name__ == "ServiceCall"
