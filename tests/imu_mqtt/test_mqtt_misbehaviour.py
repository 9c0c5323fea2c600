"""M16: a broker that misbehaves costs bounded memory, a few lines of log, and no time."""

import queue
import signal
import time
from tempfile import TemporaryDirectory

import pytest

from rosbase.runtime.backoff import Backoff
from support.command import RunningRosbase
from support.memory import worst_growth_kb
from support.misbehaviour import KINDS, Kind, good
from support.mqtt import GOOD, SUBSCRIBE, Peer, ScriptedBroker, packet, sends
from support.mqtt_rig import MqttRig, elapsed, warnings
from support.waiting import wait_until

MOST_GROWTH_KB = 20_000
# Some for each loss, each return, and what the health says of both.
MOST_LINES = 25
WATCHED_S = 2.0
END_S = 3.0


def address_of(broker: ScriptedBroker, kind: Kind) -> str:
    return broker.address.replace("tcp", kind.scheme)


def reader_of(broker: ScriptedBroker, kind: Kind) -> RunningRosbase:
    values = {
        "comm_t": "mqtt",
        "server_address": address_of(broker, kind),
        "mqtt_version": kind.version,
        "qos": kind.qos,
        "keepalive": 1,
    }
    given = [part for name, value in values.items() for part in ("-p", f"{name}:={value}")]
    return RunningRosbase("imu", *given, "--topic-echo")


@pytest.mark.once
@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_m16_the_reader_does_not_grow_says_little_reads_a_good_broker_again_and_ends(
    broker: ScriptedBroker, kind: Kind
) -> None:
    broker.behaviour = good(kind)
    with reader_of(broker, kind) as reader:
        reader.waits_for("angular_velocity", where=reader.out)
        dials = broker.dials
        broker.behaviour = kind.misbehave
        broker.drop()
        wait_until(lambda: broker.dials > dials, "the misbehaviour")
        assert worst_growth_kb(reader.process.pid, WATCHED_S) < MOST_GROWTH_KB
        broker.behaviour = good(kind)
        dials = broker.dials
        broker.drop()
        wait_until(lambda: broker.dials > dials, "a good connection")
        samples = len(reader.out.lines)
        wait_until(lambda: len(reader.out.lines) > samples, "a sample of a good broker")
        broker.behaviour = kind.misbehave
        broker.drop()
        assert worst_growth_kb(reader.process.pid, 0.5) < MOST_GROWTH_KB
        begun_s = time.monotonic()
        assert reader.end(signal.SIGINT) == 0
        assert time.monotonic() - begun_s < END_S
        log = [line for line in reader.err.lines if line.startswith("[")]
        assert len(log) <= MOST_LINES, log
        assert "Traceback" not in reader.err


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_m16_stop_and_close_return_within_a_second(
    rig: MqttRig, broker: ScriptedBroker, kind: Kind
) -> None:
    broker.behaviour = kind.misbehave
    transport = rig.transport(
        address_of(broker, kind), mqtt_version=kind.version, qos=kind.qos, wait_for_broker=True
    )
    transport.start(lambda frame, stamp_ns: None)
    wait_until(lambda: broker.dials, "the misbehaviour")
    assert elapsed(transport.stop) < 1.0
    transport.start(lambda frame, stamp_ns: None)
    assert elapsed(transport.close) < 1.0


def test_m8_a_message_of_qos_2_is_handed_over_once_when_it_arrives_and_acknowledged(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    answers: queue.Queue[tuple[int, bytes]] = queue.Queue()

    def sends_twice(peer: Peer) -> None:
        peer.accept()
        peer.serve(until=SUBSCRIBE)
        first = packet(0x34, b"\0\1a\0\7first")
        peer.send(first + packet(0x3C, b"\0\1a\0\7first") + packet(0x3C, b"\0\1a\0\x08new"))
        while True:
            kind, body = peer.receive()
            answers.put((kind, body))
            if answers.qsize() == 3:
                # Released, so the id means another message now.
                peer.send(packet(0x62, b"\0\7") + packet(0x3C, b"\0\1a\0\7second"))

    broker.behaviour = sends_twice
    transport = rig.started(broker.address, qos=2, mqtt_topic="a")
    assert [rig.next() for _ in range(3)] == [b"first", b"new", b"second"]
    assert transport.health.frame_errors == {"duplicate": 1}
    received = [answers.get(timeout=20) for _ in range(5)]
    assert received == [
        (0x50, b"\0\7"), (0x50, b"\0\7"), (0x50, b"\0\x08"), (0x70, b"\0\7"), (0x50, b"\0\7"),
    ]  # fmt: skip


def test_m16_a_broker_that_takes_no_answers_is_left_and_said_so(rig: MqttRig) -> None:
    def never_reads(peer: Peer) -> None:
        peer.accept()
        peer.serve(until=SUBSCRIBE)
        while True:
            peer.send(b"".join(packet(0x32, b"\0\1a\0\7") for _ in range(500)))

    with (
        # Of a Unix socket the system keeps little; of one on TCP some megabytes.
        TemporaryDirectory(dir="/tmp") as folder,
        ScriptedBroker(never_reads, path=f"{folder}/broker") as broker,
    ):
        transport = rig.started(broker.address, qos=1)
        named = "does not read what it is sent"
        wait_until(lambda: named in transport.health.last_error, "the reason")
        broker.behaviour = sends(GOOD)
        wait_until(lambda: rig.next() == b"good", "a message of a good broker")
        transport.close()


def test_m16_reasons_that_a_broker_makes_up_do_not_fill_the_log(
    rig: MqttRig,
    broker: ScriptedBroker,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Backoff, "next_s", lambda self: 0.01)
    broker.behaviour = KINDS["refuses in other words"].misbehave
    transport = rig.started(broker.address, mqtt_version="5", wait_for_broker=True)
    wait_until(lambda: broker.dials > 40, "many tries")
    assert len(warnings(caplog)) < 12
    assert transport.health.last_error.endswith("keeps failing, each time for another reason")


def test_m16_what_a_broker_says_at_the_end_is_quoted_as_one_line(
    rig: MqttRig, broker: ScriptedBroker, caplog: pytest.LogCaptureFixture
) -> None:
    broker.behaviour = KINDS["refers elsewhere"].misbehave
    rig.started(broker.address, mqtt_version="5", wait_for_broker=True)
    wait_until(lambda: warnings(caplog), "the reason")
    (line, *_) = warnings(caplog)
    assert line.isprintable()
    assert (
        r"ended the connection: Use another server (\x1b[2J\n[INFO] [reader]: all is well" in line
    )
    assert "it refers to mqtt" in line
