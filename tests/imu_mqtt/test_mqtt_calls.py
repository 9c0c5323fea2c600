"""What the contract does not ask of the four calls; the rest is in test_mqtt_contract.py."""

import threading

import pytest

from imu_mqtt.simulator import EmbeddedBroker
from imu_mqtt.transport import STOP_TIMEOUT_S, MqttTransport
from rosbase.clock import SystemClock
from rosbase.contracts.transport import TransportContext, TransportState
from rosbase.errors import TransportError
from rosbase.logger import RosbaseLogger
from support.mqtt import SUBSCRIBE, Peer, Publisher, ScriptedBroker, publish_packet, serves
from support.mqtt_rig import MqttRig, config, elapsed, network_threads, wait_for_state
from support.waiting import wait_until


def message(payload: bytes) -> bytes:
    return publish_packet(b"esp32/imu", payload)


@pytest.mark.parametrize("qos", [0, 1, 2])
def test_messages_come_through_whole_and_in_order(
    rig: MqttRig, embedded: EmbeddedBroker, publisher: Publisher, qos: int
) -> None:
    transport = rig.started(embedded.address, qos=qos)
    for number in range(100):
        publisher.publish(b"%d" % number, qos=qos)
    assert [int(rig.next()) for _ in range(100)] == list(range(100))
    assert transport.health.frame_errors == {}


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
