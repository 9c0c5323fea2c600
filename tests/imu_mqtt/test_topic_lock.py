"""Which of the topics under a wildcard is read, and for how long; without any broker."""

import json
from collections.abc import Iterator
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from imu_mqtt.simulator import EmbeddedBroker
from imu_mqtt.subscription import Subscription
from imu_mqtt.topic_lock import LEAST_TIMEOUT_S, TopicLock
from imu_mqtt.transport import MqttTransport
from rosbase.clock import SystemClock
from rosbase.contracts.stamper import Stamper
from rosbase.contracts.transport import Tally, TransportContext
from rosbase.logger import RosbaseLogger
from rosbase.testing import ManualClock, RecordingSubscriber
from support.mqtt import Publisher, ScriptedBroker, publish_packet
from support.mqtt_rig import config
from support.waiting import wait_until

SAMPLE = b'{"acc":[0,0,9.8]}'
HELLO = b'{"hello":"bench 3"}'


def is_sample(frame: bytes, stamp_ns: int = 0) -> bool:
    """What a reader answers."""
    return b'"acc"' in frame


class Rig:
    """A subscription under a wildcard in virtual time, and what was handed over."""

    def __init__(self, *, stale_timeout_s: float = 1.0, answers: bool = True) -> None:
        self.clock, self.tally = ManualClock(), Tally()
        self.subscriber = RecordingSubscriber(then=is_sample if answers else None)
        logger = RosbaseLogger("mqtt_test", self.clock)
        context = TransportContext(self.clock, logger, stale_timeout_s)
        self.stamper = Stamper(context, self.tally)
        self.subscription = Subscription(
            self.subscriber, self.tally, context, self.stamper, is_filter=True
        )

    def take(self, topic: str, payload: bytes = SAMPLE, after_s: float = 0.0) -> bool:
        """A message of that topic; whether it was handed over."""
        self.clock.advance(after_s)
        before = len(self.subscriber.frames)
        # Nothing has waited: the reader was there all the time.
        self.stamper.look(self.clock.monotonic_ns())
        read_ns = self.stamper.read()
        self.subscription.take(
            payload,
            read_ns,
            topic=topic,
            retained=False,
            redelivered=False,
            fault="",
            size=len(payload),
        )
        self.subscription.deliver(read_ns)
        return len(self.subscriber.frames) > before


@pytest.fixture
def rig(caplog: pytest.LogCaptureFixture) -> Rig:
    caplog.set_level("INFO", logger="rosbase")
    return Rig()


def test_what_gives_no_sample_is_not_held_on_to(rig: Rig) -> None:
    assert rig.take("lab/hello", HELLO)
    assert rig.take("lab/imu")
    assert not rig.take("lab/hello", HELLO)
    assert rig.take("lab/imu")
    assert rig.tally.frame_errors == {"other_topic": 1}


def test_until_there_is_a_sample_every_topic_is_handed_over(rig: Rig) -> None:
    topics = [f"lab/{number}" for number in range(20)]
    assert all(rig.take(topic, HELLO, after_s=0.1) for topic in topics)
    assert rig.tally.frame_errors == {}
    assert rig.tally.last_data_ns == rig.clock.monotonic_ns()


def test_two_devices_at_once_stay_with_one(rig: Rig, caplog: pytest.LogCaptureFixture) -> None:
    handed_over = [rig.take(f"lab/imu{turn % 2}", after_s=0.01) for turn in range(2000)]
    assert handed_over == [True, False] * 1000
    assert caplog.messages == ["reading lab/imu0"]


def test_a_device_that_falls_silent_makes_way_and_that_is_said_once(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    assert rig.take("lab/imu")
    assert not rig.take("lab/imu2", after_s=1.0)
    assert rig.take("lab/imu2", after_s=0.1)
    assert not rig.take("lab/imu", after_s=0.5)
    assert caplog.messages == [
        "reading lab/imu",
        "no sample from lab/imu for 1.1 s: the next topic that gives one is read",
        "reading lab/imu2",
    ]


def test_a_device_that_sends_something_else_makes_way_too(rig: Rig) -> None:
    assert rig.take("lab/imu")
    for _ in range(11):
        assert rig.take("lab/imu", b"heartbeat", after_s=0.1)
    assert rig.take("lab/imu2")
    assert not rig.take("lab/imu", b"heartbeat")


def test_messages_of_others_are_no_sign_of_life_as_long_as_one_is_held(rig: Rig) -> None:
    assert rig.take("lab/imu")
    last_ns = rig.tally.last_data_ns
    assert not any(rig.take("lab/imu2", after_s=0.09) for _ in range(10))
    assert rig.tally.last_data_ns == last_ns


def test_the_held_topic_is_handed_over_however_late_it_comes(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    assert all(rig.take("lab/imu", after_s=10.0) for _ in range(5))
    assert caplog.messages == ["reading lab/imu"]


def test_a_slow_device_among_others_does_not_fill_the_log(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(20):
        assert rig.take("lab/imu", after_s=0.5)
        assert rig.take("lab/hello", HELLO, after_s=1.5)
    assert len(caplog.messages) <= 3


def test_the_time_is_the_readers_stale_timeout_and_a_second_at_least() -> None:
    slow = Rig(stale_timeout_s=5.0)
    slow.take("lab/imu")
    assert not slow.take("lab/imu2", after_s=4.9)
    assert slow.take("lab/imu2", after_s=0.2)
    hasty = Rig(stale_timeout_s=0.01)
    hasty.take("lab/imu")
    assert not hasty.take("lab/imu2", after_s=LEAST_TIMEOUT_S - 0.01)


def test_the_time_without_a_connection_does_not_count(rig: Rig) -> None:
    rig.take("lab/imu")
    rig.clock.advance(60.0)
    rig.subscription.answer()
    assert not rig.take("lab/imu2")
    assert rig.take("lab/imu")


def test_what_does_not_answer_gets_the_first_topic_that_sends_a_message() -> None:
    rig = Rig(answers=False)
    assert rig.take("lab/hello", HELLO)
    assert not rig.take("lab/imu")
    assert rig.take("lab/imu", after_s=1.1)


class Message(NamedTuple):
    """One message, and how long after the one before."""

    after_s: float
    topic: str
    is_sample: bool


messages = st.lists(
    st.builds(
        Message,
        st.sampled_from([0.0, 0.1, 0.5, 0.9, 1.1, 3.0]),
        st.sampled_from(["a", "b", "c"]),
        st.booleans(),
    ),
    max_size=60,
)


@given(messages)
def test_a_message_is_admitted_if_no_other_topic_gave_a_sample_within_the_timeout(
    several: list[Message],
) -> None:
    clock = ManualClock()
    lock = TopicLock(1.0, RosbaseLogger("mqtt_test", clock))
    held, held_ns = "", 0
    for after_s, topic, is_a_sample in several:
        clock.advance(after_s)
        now_ns = clock.monotonic_ns()
        admitted = lock.admits(topic, now_ns)
        is_late = now_ns - held_ns > 1_000_000_000
        assert admitted == (held in ("", topic) or is_late)
        if admitted and topic != held:
            held = ""
        if admitted and is_a_sample:
            lock.note_sample(topic, now_ns)
            held, held_ns = topic, now_ns


@pytest.fixture
def started() -> Iterator[list[MqttTransport]]:
    made: list[MqttTransport] = []
    yield made
    for transport in made:
        transport.close()


def subscriber_on(address: str, made: list[MqttTransport]) -> RecordingSubscriber:
    """Reads `lab/#` there, and answers as a reader does."""
    subscriber = RecordingSubscriber(then=is_sample)
    context = TransportContext(SystemClock(), RosbaseLogger("mqtt_test"))
    made.append(MqttTransport(config(address, mqtt_topic="lab/#"), context))
    made[-1].start(subscriber)
    return subscriber


def numbered(device: str, number: int) -> bytes:
    return json.dumps({"acc": [0, 0, 9.8], "from": device, "n": number}).encode()


def test_on_a_broker_the_first_that_gives_samples_is_read_until_it_falls_silent(
    embedded: EmbeddedBroker, publisher: Publisher, started: list[MqttTransport]
) -> None:
    subscriber = subscriber_on(embedded.address, started)
    publisher.publish(HELLO, "lab/hello")
    sent = [numbered("imu", number) for number in range(20)]
    for number, payload in enumerate(sent):
        publisher.publish(payload, "lab/imu")
        publisher.publish(numbered("imu2", number), "lab/imu2")
    sent.append(numbered("imu", 20))
    publisher.publish(sent[-1], "lab/imu")
    assert subscriber.wait_for(1 + len(sent), 20.0)
    assert subscriber.frames == [HELLO, *sent]
    assert started[0].health.frame_errors == {"other_topic": 20}

    def takes_over() -> bool:
        publisher.publish(numbered("imu2", 99), "lab/imu2")
        return numbered("imu2", 99) in subscriber.frames

    wait_until(takes_over, "the other device to be read")
    publisher.publish(numbered("imu", 99), "lab/imu")
    publisher.publish(b"last", "lab/imu2")
    assert subscriber.wait_for_frame(b"last", 20.0)
    assert numbered("imu", 99) not in subscriber.frames


def test_after_the_connection_was_lost_the_same_device_is_read(
    broker: ScriptedBroker, started: list[MqttTransport]
) -> None:
    subscriber = subscriber_on(broker.address, started)
    broker.send(publish_packet(b"lab/imu", numbered("imu", 0)))
    assert subscriber.wait_for(1, 20.0)
    for turn in range(1, 4):
        dials = broker.dials
        broker.drop()

        def is_back(dials: int = dials) -> bool:
            return broker.dials > dials and started[0].is_open

        wait_until(is_back, "a connection")

        def arrives(turn: int = turn) -> bool:
            broker.send(publish_packet(b"lab/imu2", numbered("imu2", turn)))
            broker.send(publish_packet(b"lab/imu", numbered("imu", turn)))
            return numbered("imu", turn) in subscriber.frames

        wait_until(arrives, "the first device's samples")
    assert not [frame for frame in subscriber.frames if b'"imu2"' in frame]
