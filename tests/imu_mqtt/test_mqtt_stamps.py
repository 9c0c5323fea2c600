"""Stamps of messages, as a broker and a network bring them."""

import threading
import time
from itertools import pairwise

from support.mqtt import Peer, ScriptedBroker, publish_packet
from support.mqtt_rig import MqttRig
from support.waiting import wait_until

SUBSCRIBE = 0x82


def packets(*numbers: int) -> bytes:
    return b"".join(publish_packet(b"esp32/imu", b"%d" % number) for number in numbers)


def test_several_packets_in_one_segment_at_10_messages_a_second_are_as_far_apart_as_usual(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    def behave(peer: Peer) -> None:
        peer.accept()
        peer.serve(until=SUBSCRIBE)
        for number in range(0, 30, 2):
            peer.send(packets(number, number + 1))
            over.wait(0.2)
        peer.serve()

    over = threading.Event()
    broker.behaviour = behave
    transport = rig.started(broker.address)
    received = [rig.frames.get(timeout=20) for _ in range(30)]
    over.set()
    assert [int(frame) for frame, _ in received] == list(range(30))
    gaps_ms = [(after[1] - before[1]) / 1e6 for before, after in pairwise(received)]
    assert min(gaps_ms) > 0.0
    # The first ten are stamped before it is known how often messages come.
    assert sorted(gaps_ms[20:])[len(gaps_ms[20:]) // 2] > 50.0
    assert 80e6 < transport.health.interval_ns < 130e6


def test_messages_behind_which_the_broker_hangs_up_are_handed_over(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    def behave(peer: Peer) -> None:
        peer.accept()
        peer.serve(until=SUBSCRIBE)
        peer.send(packets(1, 2, 3))

    broker.behaviour = behave
    rig.started(broker.address)
    assert [int(rig.next()) for _ in range(3)] == [1, 2, 3]


def test_a_consumer_that_keeps_the_reader_for_over_a_second_makes_messages_late(
    rig: MqttRig, broker: ScriptedBroker
) -> None:
    go_on = threading.Event()

    def hold(frame: bytes, stamp_ns: int) -> None:
        rig.keep(frame, stamp_ns)
        if frame == b"0":
            go_on.wait(20)

    transport = rig.transport(broker.address)
    transport.start(hold)
    broker.send(packets(0))
    assert rig.next() == b"0"
    broker.send(packets(1, 2, 3))
    # The promise is about what waits for more than a second.
    time.sleep(1.3)
    go_on.set()
    wait_until(lambda: transport.health.late_frames == 3, "the late messages")
    assert transport.health.frame_errors == {"late": 3}
    broker.send(packets(4))
    assert rig.next() == b"4"
