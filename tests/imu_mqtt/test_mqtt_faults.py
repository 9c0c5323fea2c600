"""M1 to M14, as the README of imu-mqtt numbers them; M11 is tested with mosquitto."""

import os
import queue
import random
import resource
import threading

import pytest

from imu_mqtt.network_thread import NetworkThread
from imu_mqtt.packets import MOST_PACKET_BYTES
from imu_mqtt.simulator import EmbeddedBroker
from imu_mqtt.subscription import MAX_PAYLOAD_BYTES
from rosbase.contracts.transport import TransportState
from rosbase.errors import DeviceNotFoundError, TransportError
from support.mqtt import (
    GOOD,
    Peer,
    Publisher,
    ScriptedBroker,
    falls_silent,
    packet,
    publish_packet,
    refuses,
    says_nothing,
    sends,
    serves,
)
from support.mqtt_rig import MqttRig, elapsed, wait_for_state
from support.waiting import wait_until


def free_port() -> int:
    with ScriptedBroker() as broker:
        return broker.port


def test_m1_an_absent_broker_is_refused_in_one_line(
    rig: MqttRig, caplog: pytest.LogCaptureFixture
) -> None:
    address = f"tcp://127.0.0.1:{free_port()}"
    transport = rig.transport(address)
    with pytest.raises(DeviceNotFoundError, match=f"^there is no broker at {address}$"):
        transport.open()
    assert transport.health.state is TransportState.CLOSED
    assert not caplog.records, "who called is told; nothing goes on that must be logged"


def test_m1_an_absent_broker_is_waited_for_and_picked_up_when_it_comes(
    rig: MqttRig, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO", logger="rosbase")
    port = free_port()
    transport = rig.transport(f"tcp://127.0.0.1:{port}", wait_for_broker=True)
    transport.open()
    transport.start(rig.keep)
    assert transport.health.state is TransportState.RECONNECTING
    assert "there is no broker" in transport.health.last_error
    with ScriptedBroker(sends(GOOD), port):
        assert elapsed(lambda: wait_for_state(transport, TransportState.CONNECTED)) < 2.0
        assert rig.next() == b"good"
        assert transport.health.reconnects == 0, "it came late, it did not come back"
        assert transport.health.last_error == ""
        assert len(caplog.messages) == 2, "it is not there; it is there"
        transport.close()


def test_m2_data_flows_again_within_two_seconds_of_a_brokers_return(
    rig: MqttRig, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO", logger="rosbase")
    broker = ScriptedBroker()
    transport = rig.started(broker.address)
    for times in range(1, 4):
        broker.close()
        wait_until(lambda: "no broker" in transport.health.last_error, "a try that fails")
        assert not transport.is_open
        broker = ScriptedBroker(sends(GOOD), broker.port)
        assert elapsed(lambda: rig.frames.get(timeout=20)) < 2.0
        assert transport.health.reconnects == times
    transport.close()
    broker.close()
    assert len(caplog.messages) == 1 + 3 * 3, "lost, not there, is back"


def test_m2_a_reset_of_the_connection_loses_no_subscription(
    rig: MqttRig, embedded: EmbeddedBroker, publisher: Publisher
) -> None:
    transport = rig.started(embedded.address)
    rig.prove(publisher.publish)
    publisher.close()
    port = embedded.port
    embedded.close()
    wait_for_state(transport, TransportState.RECONNECTING)
    again = EmbeddedBroker(port)
    with Publisher(port) as other:
        rig.prove(other.publish)
    transport.close()
    again.close()


NO_PACKETS = {
    "not MQTT": b"HTTP/1.1 400 Bad Request\r\n" + b"Server: web\r\n" * 20,
    "zeros": bytes(1000),
    "an endless length": b"\x30\xff\xff\xff\xff\xff",
    "an answer to nothing": packet(0x90, b"\x12\x34\x00"),
    "an empty answer": packet(0x90),
    "a message without topic": packet(0x30),
    "a topic that is cut": packet(0x30, b"\0\x20abc"),
    "a topic that is no text": publish_packet(b"\xff\xfe", b"x"),
    "a second connection": packet(0x20, b"\0\0"),
    "a refusal that comes late": packet(0x20, b"\0\5"),
    "a packet of the future": packet(0xF0, b"abc"),
}


@pytest.mark.parametrize("data", NO_PACKETS.values(), ids=NO_PACKETS)
def test_m4_whatever_a_broker_sends_data_flows_again(
    rig: MqttRig, broker: ScriptedBroker, caplog: pytest.LogCaptureFixture, data: bytes
) -> None:
    broker.behaviour = sends(data, GOOD)
    transport = rig.started(broker.address, mqtt_topic="#")
    wait_until(
        lambda: rig.frames.qsize() or transport.health.state is TransportState.RECONNECTING,
        "the end of it, or of the connection",
        timeout_s=2.0,
    )
    broker.behaviour = serves
    dials = broker.dials
    broker.drop()
    wait_until(lambda: broker.dials > dials and transport.is_open, "a new connection")
    rig.prove(lambda payload: broker.send(publish_packet(b"esp32/imu", payload)))
    assert "Traceback" not in caplog.text


def test_m4_noise_ends_connections_but_not_the_transport(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    choose = random.Random(4)

    def noise(peer: Peer) -> None:
        if broker.dials % 2:
            peer.accept()
        peer.send(choose.randbytes(choose.randrange(1, 2000)))

    broker.behaviour = noise
    transport = rig.started(broker.address, wait_for_broker=True)
    wait_until(lambda: broker.dials >= 4, "some of it")
    broker.behaviour = sends(GOOD)
    assert rig.next() == b"good"
    assert transport.health.state is TransportState.CONNECTED


def test_m4_half_a_packet_harms_nobody(rig: MqttRig, broker: ScriptedBroker) -> None:
    broker.behaviour = sends(GOOD, GOOD[:7])
    transport = rig.started(broker.address)
    assert rig.next() == b"good"
    broker.behaviour = sends(GOOD)
    broker.drop()
    assert rig.next() == b"good"
    assert transport.health.frame_errors == {}


def test_m5_a_slow_consumer_keeps_its_connection_and_loses_nothing(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    pause = threading.Event()

    def slowly(frame: bytes, stamp_ns: int) -> None:
        pause.wait(0.01)
        rig.keep(frame, stamp_ns)

    # More than two seconds' worth, so that keep-alive is due behind it, more than once.
    broker.behaviour = sends(*[publish_packet(b"esp32/imu", b"%d" % n) for n in range(300)])
    transport = rig.transport(broker.address, keepalive=1)
    transport.start(slowly)
    assert [int(rig.next()) for _ in range(300)] == list(range(300))
    assert (transport.health.reconnects, broker.dials) == (0, 1)


def test_m8_a_message_that_is_sent_again_is_handed_over_once(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    again = publish_packet(b"esp32/imu", b"good", duplicate=True)
    new = publish_packet(b"esp32/imu", b"lost on its first way", duplicate=True)
    broker.behaviour = sends(GOOD, GOOD, again, new, publish_packet(b"esp32/imu", b"end"))
    transport = rig.started(broker.address, qos=1)
    handed_over = [rig.next() for _ in range(4)]
    assert handed_over == [b"good", b"good", b"lost on its first way", b"end"]
    assert transport.health.frame_errors == {"duplicate": 1}


def test_m9_a_half_open_connection_is_noticed_by_keep_alive(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    broker.behaviour = falls_silent
    transport = rig.started(broker.address, keepalive=1)
    wait_for_state(transport, TransportState.CONNECTED)
    broker.behaviour = sends(GOOD)
    assert elapsed(lambda: rig.frames.get(timeout=20)) < 4.0, "two keep-alives and a try"
    assert transport.health.reconnects == 1


def test_m9_a_silent_broker_is_no_proof_that_data_arrives(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    broker.behaviour = sends(GOOD)
    transport = rig.started(broker.address, keepalive=1)
    rig.next()
    last_ns = transport.health.last_data_ns
    wait_until(lambda: transport.health.last_data_ns, "the first data")
    broker.send(packet(0xD0) * 3)
    assert transport.health.last_data_ns == last_ns, "a ping is not data"


@pytest.mark.parametrize("scheme", ["tcp", "mqtts", "ws"])
# paho leaves a socket whose handshake has failed to Python, which closes it.
@pytest.mark.filterwarnings("ignore:unclosed <s:ResourceWarning")
def test_m10_a_broker_that_does_not_answer_holds_nobody_for_long(
    rig: MqttRig, broker: ScriptedBroker, scheme: str
) -> None:
    broker.behaviour = says_nothing
    address = broker.address.replace("tcp", scheme)
    transport = rig.transport(address)

    def open_it() -> None:
        with pytest.raises(DeviceNotFoundError, match=f"^no answer from {address}$"):
            transport.open()

    assert elapsed(open_it) < 4.0
    assert elapsed(transport.close) < 0.5


def test_m10_stopping_does_not_wait_for_a_broker_that_does_not_answer(
    rig: MqttRig, broker: ScriptedBroker, caplog: pytest.LogCaptureFixture
) -> None:
    transport = rig.started(broker.address)
    broker.behaviour = says_nothing
    broker.drop()
    wait_until(lambda: broker.dials == 2 and broker.peers, "a try")
    assert elapsed(transport.stop) < 0.5
    assert elapsed(transport.close) < 0.5
    assert "left behind" not in caplog.text


def test_m10_what_opens_is_known_to_close_before_it_runs(
    rig: MqttRig, broker: ScriptedBroker, monkeypatch: pytest.MonkeyPatch
) -> None:
    transport = rig.transport(broker.address)
    states = []
    start = NetworkThread.start

    def noting(thread: NetworkThread) -> None:
        states.append(transport.health.state)
        start(thread)

    monkeypatch.setattr(NetworkThread, "start", noting)
    transport.open()
    assert states == [TransportState.RECONNECTING]


def test_m10_closing_ends_an_open_that_waits(rig: MqttRig, broker: ScriptedBroker) -> None:
    broker.behaviour = says_nothing
    transport = rig.transport(broker.address, wait_for_broker=True)
    opening = threading.Thread(target=transport.open)
    opening.start()
    wait_until(lambda: broker.peers, "a try")
    assert elapsed(transport.close) < 0.5
    opening.join(10)
    assert transport.health.state is TransportState.CLOSED


BAD_PAYLOADS = {
    "empty": (b"", "empty"),
    "blank": (b" \r\n\0", "empty"),
    "just too long": (b"x" * (MAX_PAYLOAD_BYTES + 1), "overlong"),
    "huge": (b"x" * 8_000_000, "overlong"),
}


@pytest.mark.parametrize(("payload", "reason"), BAD_PAYLOADS.values(), ids=BAD_PAYLOADS)
def test_m12_empty_and_huge_payloads_are_counted_and_dropped(
    rig: MqttRig, broker: ScriptedBroker, payload: bytes, reason: str
) -> None:
    broker.behaviour = sends(publish_packet(b"esp32/imu", payload), GOOD)
    transport = rig.started(broker.address)
    assert rig.next() == b"good"
    assert transport.health.frame_errors == {reason: 1}
    # Of what is much too long the middle is thrown away.
    assert transport.health.received_bytes >= min(len(payload), MOST_PACKET_BYTES) + 4


def test_m12_binary_goes_through_as_it_is(rig: MqttRig, broker: ScriptedBroker) -> None:
    noise = random.Random(12).randbytes(MAX_PAYLOAD_BYTES)
    broker.behaviour = sends(publish_packet(b"esp32/imu", noise))
    rig.started(broker.address)
    assert rig.next() == noise


def test_m14_nothing_piles_up_while_there_is_no_broker(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    said: queue.Queue[bytes] = queue.Queue()

    def listens(peer: Peer) -> None:
        peer.accept()
        kind, body = peer.receive()
        while kind & 0xF0 == 0x30:
            said.put(body)
            kind, body = peer.receive()

    broker.behaviour = listens
    transport = rig.transport(broker.address, status_topic="robot/status", wait_for_broker=True)
    transport.open()
    assert b"online" in said.get(timeout=20)
    before_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    broker.behaviour = refuses(3)
    broker.drop()
    for _ in range(200):
        transport.start(rig.keep)
        transport.stop()
    broker.behaviour = listens
    assert b"online" in said.get(timeout=20)
    transport.close()
    assert b"offline" in said.get(timeout=20)
    assert said.empty(), "of each connection one line, and of what was not, none"
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before_kb < 8_000


def test_no_reader_where_the_system_has_no_more_threads_or_descriptors(
    rig: MqttRig, broker: ScriptedBroker, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_pipe() -> tuple[int, int]:
        raise OSError(24, "Too many open files")

    def no_thread(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    transport = rig.transport(broker.address)
    with monkeypatch.context() as patch:
        patch.setattr(os, "pipe", no_pipe)
        with pytest.raises(TransportError, match="Too many"):
            transport.start(rig.keep)
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", no_thread)
        with pytest.raises(TransportError, match="new thread"):
            transport.start(rig.keep)
    transport.start(rig.keep)
    assert transport.is_open
