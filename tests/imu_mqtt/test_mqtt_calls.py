"""open, start, stop and close: in any order, from any thread, and always in time."""

import queue
import random
import threading

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule, run_state_machine_as_test

from imu_mqtt.simulator import EmbeddedBroker
from imu_mqtt.transport import STOP_TIMEOUT_S, MqttTransport
from rosbase.clock import SystemClock
from rosbase.errors import DeviceNotFoundError, TransportError
from rosbase.logger import RosbaseLogger
from rosbase.transport import TransportContext, TransportState
from support.mqtt import SUBSCRIBE, Peer, Publisher, ScriptedBroker, publish_packet, serves
from support.mqtt_rig import MqttRig, config, elapsed, network_threads, wait_for_state
from support.waiting import wait_until


def message(payload: bytes) -> bytes:
    return publish_packet(b"esp32/imu", payload)


@pytest.mark.parametrize("ending", ["stop", "close"])
def test_ending_returns_at_once(rig: MqttRig, embedded: EmbeddedBroker, ending: str) -> None:
    transport = rig.started(embedded.address)
    assert elapsed(getattr(transport, ending)) < 0.5
    assert transport.is_open is (ending == "stop")


def test_m10_all_calls_may_be_made_twice_and_before_any_other(
    rig: MqttRig, embedded: EmbeddedBroker
) -> None:
    transport = rig.transport(embedded.address)
    transport.stop()
    transport.close()
    for call in (transport.open, transport.open, transport.stop, transport.stop):
        call()
    transport.start(rig.keep)
    transport.start(rig.keep)
    assert len(network_threads()) == 1
    for call in (transport.close, transport.close, transport.stop, transport.open):
        call()
    assert transport.is_open


def test_nothing_is_left_of_a_transport_that_is_closed(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    transport = rig.started(broker.address)
    transport.close()
    assert network_threads() == []
    wait_until(lambda: not broker.peers, "the end of the connection")
    assert transport.health.state is TransportState.CLOSED


def test_start_opens_what_is_not_open_or_says_why_not(
    rig: MqttRig, embedded: EmbeddedBroker, publisher: Publisher
) -> None:
    transport = rig.transport("tcp://127.0.0.1:1")
    with pytest.raises(DeviceNotFoundError):
        transport.start(rig.keep)
    rig.transport(embedded.address).start(rig.keep)
    rig.prove(publisher.publish)


@pytest.mark.parametrize("qos", [0, 1, 2])
def test_messages_come_through_whole_and_in_order(
    rig: MqttRig, embedded: EmbeddedBroker, publisher: Publisher, qos: int
) -> None:
    transport = rig.started(embedded.address, qos=qos)
    for number in range(100):
        publisher.publish(b"%d" % number, qos=qos)
    assert [int(rig.next()) for _ in range(100)] == list(range(100))
    assert transport.health.frame_errors == {}


def test_it_starts_again_after_stop_and_after_close(
    rig: MqttRig, embedded: EmbeddedBroker, publisher: Publisher
) -> None:
    transport = rig.started(embedded.address)
    for ending in (transport.stop, transport.close, transport.stop):
        ending()
        transport.start(rig.keep)
        rig.prove(publisher.publish)
        assert rig.frames.empty()


@pytest.mark.parametrize("ending", ["stop", "close"])
@pytest.mark.parametrize("qos", [0, 1])
def test_what_was_published_before_start_is_not_read(
    rig: MqttRig, embedded: EmbeddedBroker, publisher: Publisher, ending: str, qos: int
) -> None:
    publisher.publish(b"kept", retain=True)
    transport = rig.started(embedded.address, qos=qos, client_id="imu")
    rig.prove(publisher.publish)
    getattr(transport, ending)()
    publisher.publish(b"while nobody listens")
    transport.start(rig.keep)
    rig.prove(publisher.publish)
    assert rig.frames.empty()
    assert transport.health.frame_errors == {"retained": 2}


def test_what_was_under_way_when_it_stopped_is_not_read_after_the_next_start(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    def sends_late(peer: Peer) -> None:
        peer.accept()
        peer.serve(until=SUBSCRIBE)
        kind, body = peer.receive()
        while kind != SUBSCRIBE:
            kind, body = peer.receive()
        peer.send(message(b"late") + b"\x90\3" + body[:2] + b"\0" + message(b"new"))
        peer.serve()

    broker.behaviour = sends_late
    transport = rig.started(broker.address)
    transport.stop()
    transport.start(rig.keep)
    assert rig.next() == b"new"


def test_nothing_is_handed_over_once_stop_has_returned(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    transport = rig.started(broker.address)
    broker.send(message(b"x") * 1000)
    rig.next()
    transport.stop()
    handed_over = transport.health.frames
    broker.send(message(b"y") * 100)
    transport.start(lambda frame, stamp_ns: None)
    transport.stop()
    assert transport.health.frames == handed_over


@pytest.mark.parametrize("ending", ["stop", "close"])
def test_m10_the_calls_may_come_from_within_on_frame(
    rig: MqttRig, embedded: EmbeddedBroker, publisher: Publisher, ending: str
) -> None:
    transport = rig.transport(embedded.address)
    called = threading.Event()
    handed_over: list[bytes] = []

    def end(frame: bytes, stamp_ns: int) -> None:
        handed_over.append(frame)
        transport.open()
        getattr(transport, ending)()
        transport.start(end)
        called.set()

    transport.start(end)
    publisher.publish(b"a")
    assert called.wait(20)
    publisher.publish(b"b")
    if ending == "close":
        wait_for_state(transport, TransportState.CLOSED)
    transport.start(rig.keep)
    rig.prove(publisher.publish)
    assert handed_over == [b"a"], "not called again after it asked to end"


def test_m10_during_a_reconnect_all_calls_return_at_once(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    transport = rig.started(broker.address)
    broker.close()
    wait_for_state(transport, TransportState.RECONNECTING)
    calls = [transport.open, transport.stop, lambda: transport.start(rig.keep), transport.close]
    for call in calls:
        assert elapsed(call) < 0.5
    assert network_threads() == []


def test_an_on_frame_that_hangs_does_not_hang_stop_and_is_left_behind(
    rig: MqttRig, broker: ScriptedBroker, caplog: pytest.LogCaptureFixture
) -> None:
    transport = rig.transport(broker.address)
    entered, leave = threading.Event(), threading.Event()

    def hang(frame: bytes, stamp_ns: int) -> None:
        entered.set()
        leave.wait(30)

    transport.start(hang)
    broker.send(message(b"x"))
    assert entered.wait(20)
    assert elapsed(transport.close) < STOP_TIMEOUT_S + 1.0
    assert "left behind" in caplog.text
    transport.start(rig.keep)
    wait_until(lambda: len(broker.peers) == 2, "another connection")
    rig.prove(lambda payload: broker.send(message(payload)))
    leave.set()
    wait_until(lambda: len(network_threads()) == 1, "the end of the one that hung")
    rig.prove(lambda payload: broker.send(message(payload)))


def test_an_on_frame_that_was_left_behind_cannot_end_its_successor(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    transport = rig.transport(broker.address)
    entered, leave, left = threading.Event(), threading.Event(), threading.Event()

    def hang(frame: bytes, stamp_ns: int) -> None:
        entered.set()
        leave.wait(30)
        transport.stop()
        transport.close()
        left.set()

    transport.start(hang)
    broker.send(message(b"x"))
    assert entered.wait(20)
    transport.stop()
    transport.start(rig.keep)
    leave.set()
    assert left.wait(10)
    wait_until(lambda: len(network_threads()) == 1, "the end of the one that hung")
    rig.prove(lambda payload: broker.send(message(payload)))


def test_a_thread_that_fails_is_noticed_and_can_be_started_again(
    rig: MqttRig, broker: ScriptedBroker, caplog: pytest.LogCaptureFixture
) -> None:
    class Clock(SystemClock):
        fails = False

        def now_ns(self) -> int:
            if self.fails:
                raise MemoryError("no more")
            return super().now_ns()

    clock = Clock()
    made = TransportContext(clock, RosbaseLogger("mqtt_test"))
    transport = MqttTransport(config(broker.address, wait_for_broker=True), made)
    rig.made.append(transport)
    transport.start(rig.keep)
    clock.fails = True
    broker.send(message(b"x"))
    wait_for_state(transport, TransportState.CLOSED)
    wait_until(lambda: not transport.is_open, "the connection to be given back")
    assert "MemoryError" in transport.health.last_error
    assert "the reader failed" in caplog.text
    with pytest.raises(TransportError, match="MemoryError"):
        transport.open()
    clock.fails = False
    broker.behaviour = serves
    transport.start(rig.keep)
    rig.prove(lambda payload: broker.send(message(payload)))


def test_any_calls_from_many_threads_end_in_time_and_leak_nothing(
    rig: MqttRig, embedded: EmbeddedBroker, publisher: Publisher
) -> None:
    transport = rig.transport(embedded.address)
    slowest: queue.Queue[float] = queue.Queue()

    def call_at_random(seed: int) -> None:
        choose = random.Random(seed)
        for _ in range(40):
            name = choose.choice(["open", "start", "stop", "close", "health"])
            if name == "health":
                assert transport.health is not None
            elif name == "start":
                slowest.put(elapsed(lambda: transport.start(rig.keep)))
            else:
                slowest.put(elapsed(getattr(transport, name)))

    threads = [threading.Thread(target=call_at_random, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        publisher.publish(b"x")
        thread.join(30)
        assert not thread.is_alive()
    assert max(slowest.queue) < STOP_TIMEOUT_S
    transport.close()
    assert transport.health.state is TransportState.CLOSED
    assert network_threads() == []


def test_any_order_of_calls_leads_where_the_last_ones_say(embedded: EmbeddedBroker) -> None:
    class Calls(RuleBasedStateMachine):
        """A transport beside the few words that describe where it should be."""

        def __init__(self) -> None:
            super().__init__()
            self.rig = MqttRig()
            self.transport = self.rig.transport(embedded.address)
            self.publisher = Publisher(embedded.port)
            self.is_open = self.is_started = False

        @rule()
        def open(self) -> None:
            self.transport.open()
            self.is_open = True

        @rule()
        def start(self) -> None:
            self.transport.start(self.rig.keep)
            self.is_open = self.is_started = True

        @rule()
        def stop(self) -> None:
            self.transport.stop()
            self.is_started = False

        @rule()
        def close(self) -> None:
            self.transport.close()
            self.is_open = self.is_started = False

        @rule()
        def publish(self) -> None:
            self.publisher.publish(b"x")
            if self.is_started:
                assert self.rig.next() == b"x"

        @invariant()
        def is_where_it_should_be(self) -> None:
            assert self.transport.is_open is self.is_open
            assert (self.transport.health.state is TransportState.CONNECTED) is self.is_open
            assert len(network_threads()) == self.is_open
            assert self.rig.frames.empty()

        def teardown(self) -> None:
            self.transport.close()
            self.publisher.close()

    run_state_machine_as_test(
        Calls,
        settings=settings(
            max_examples=30,
            stateful_step_count=15,
            deadline=None,
            suppress_health_check=list(HealthCheck),
        ),
    )
