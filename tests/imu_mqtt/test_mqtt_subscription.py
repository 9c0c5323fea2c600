"""Which messages are frames, and how those are handed over; without any broker."""

import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from imu_mqtt.subscription import MAX_PAYLOAD_BYTES, Subscription
from rosbase.contracts.stamper import Stamper
from rosbase.contracts.transport import Tally
from rosbase.errors import TransportError
from support.mqtt_rig import context, elapsed
from support.waiting import wait_until


class Rig:
    """A subscription, what it has handed over, and what was counted."""

    def __init__(self, *, is_filter: bool = False, on_frame: Any = None) -> None:
        self.frames: list[tuple[bytes, int]] = []
        self.tally = Tally()
        on_frame = on_frame or (lambda frame, stamp_ns: self.frames.append((frame, stamp_ns)))
        made = context()
        self.stamper = Stamper(made, self.tally)
        self.subscription = Subscription(
            on_frame, self.tally, made, self.stamper, is_filter=is_filter
        )

    def take(
        self,
        *payloads: bytes,
        topic: str = "a/imu",
        retained: bool = False,
        redelivered: bool = False,
        fault: str = "",
    ) -> None:
        """Messages that were read together."""
        read_ns = self.stamper.read()
        for payload in payloads:
            self.keep(
                payload,
                read_ns,
                topic=topic,
                retained=retained,
                redelivered=redelivered,
                fault=fault,
            )
        self.subscription.deliver(read_ns)

    def keep(
        self,
        payload: bytes,
        read_ns: int,
        *,
        topic: str = "a/imu",
        retained: bool = False,
        redelivered: bool = False,
        fault: str = "",
    ) -> None:
        """One of several that are read together."""
        self.subscription.take(
            payload,
            read_ns,
            topic=topic,
            retained=retained,
            redelivered=redelivered,
            fault=fault,
            size=len(payload),
        )


def started(call: Callable[[], object]) -> threading.Thread:
    thread = threading.Thread(target=call)
    thread.start()
    return thread


def test_a_message_is_a_frame_with_the_stamp_of_its_arrival() -> None:
    rig = Rig()
    before_ns = time.time_ns()
    rig.take(b"{}")
    rig.take(b"\xff\0")
    assert [frame for frame, _ in rig.frames] == [b"{}", b"\xff\0"]
    assert before_ns < rig.frames[0][1] < rig.frames[1][1] < time.time_ns()
    assert (rig.tally.frames, rig.tally.received_bytes, rig.tally.frame_errors) == (2, 4, {})


@pytest.mark.parametrize(
    ("payload", "retained", "reason"),
    [
        (b"{}", True, "retained"),
        (b"", True, "retained"),
        (b"", False, "empty"),
        (b"\0 \r\n\t", False, "empty"),
        (b"x" * (MAX_PAYLOAD_BYTES + 1), False, "overlong"),
    ],
)
def test_what_is_no_frame_is_counted_and_is_data_unless_it_was_kept(
    payload: bytes, retained: bool, reason: str
) -> None:
    rig = Rig()
    rig.take(payload, retained=retained)
    rig.take(payload, retained=retained)
    assert rig.frames == []
    assert rig.tally.frame_errors == {reason: 2}
    assert (rig.tally.frames, rig.tally.received_bytes) == (0, 2 * len(payload))
    assert (rig.tally.last_data_ns is None) == retained


def test_the_longest_payload_is_a_frame() -> None:
    rig = Rig()
    rig.take(b"x" * MAX_PAYLOAD_BYTES)
    assert len(rig.frames) == 1


def test_of_several_topics_the_first_that_sends_is_read(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", logger="rosbase")
    rig = Rig(is_filter=True)
    rig.take(b"kept for ever", topic="a/imu", retained=True)
    rig.take(b"", topic="a/imu")
    rig.take(b"1", topic="b/imu")
    rig.take(b"2", topic="a/imu")
    rig.take(b"3", topic="b/imu")
    assert [frame for frame, _ in rig.frames] == [b"1", b"3"]
    assert rig.tally.frame_errors == {"retained": 1, "empty": 1, "other_topic": 1}
    assert caplog.messages == ["reading b/imu"]


def test_what_another_device_sends_does_not_hide_that_ours_is_silent() -> None:
    rig = Rig(is_filter=True)
    rig.take(b"1", topic="a/imu")
    last_ns = rig.tally.last_data_ns
    for payload in (b"2", b"", b"x" * (MAX_PAYLOAD_BYTES + 1)):
        rig.take(payload, topic="b/imu")
    rig.take(b"kept", topic="b/imu", retained=True)
    assert rig.tally.frame_errors == {"other_topic": 4}
    assert rig.tally.last_data_ns == last_ns
    rig.take(b"3", topic="a/imu")
    assert rig.tally.last_data_ns != last_ns


def test_a_duplicate_is_what_was_seen_and_is_sent_again() -> None:
    rig = Rig()
    rig.take(b"same")
    rig.take(b"same")
    rig.take(b"same", redelivered=True)
    rig.take(b"never seen", redelivered=True)
    assert [frame for frame, _ in rig.frames] == [b"same", b"same", b"never seen"]
    assert rig.tally.frame_errors == {"duplicate": 1}


def test_what_is_remembered_of_duplicates_is_bounded() -> None:
    rig = Rig()
    for number in range(10_000):
        rig.take(b"%d" % number)
    rig.take(b"9999", redelivered=True)
    rig.take(b"0", redelivered=True)
    assert rig.tally.frame_errors == {"duplicate": 1}


def test_an_on_frame_that_raises_is_logged_at_a_limited_rate(
    caplog: pytest.LogCaptureFixture,
) -> None:
    def fail(frame: bytes, stamp_ns: int) -> None:
        raise ValueError(frame)

    rig = Rig(on_frame=fail)
    for _ in range(100):
        rig.take(b"x")
    assert rig.tally.frames == 100
    assert len(caplog.records) == 1
    assert "Traceback" in caplog.text


def test_nothing_is_handed_over_after_the_end() -> None:
    rig = Rig()
    assert rig.subscription.end(0.0)
    assert rig.subscription.end(0.0)
    rig.take(b"x")
    assert rig.frames == []


def test_the_end_waits_for_on_frame_to_return() -> None:
    entered, leave = threading.Event(), threading.Event()
    done: list[str] = []

    def work(frame: bytes, stamp_ns: int) -> None:
        entered.set()
        leave.wait(20)
        done.append("on_frame")

    rig = Rig(on_frame=work)
    delivering = started(lambda: rig.take(b"x"))
    assert entered.wait(20)
    ended: list[Any] = []
    ending = started(lambda: ended.append((rig.subscription.end(20.0), *done)))
    leave.set()
    for thread in (ending, delivering):
        thread.join(20)
    assert ended == [(True, "on_frame")]


def test_the_end_does_not_wait_for_an_on_frame_that_hangs() -> None:
    entered, leave = threading.Event(), threading.Event()

    def hang(frame: bytes, stamp_ns: int) -> None:
        entered.set()
        leave.wait(20)

    rig = Rig(on_frame=hang)
    delivering = started(lambda: rig.take(b"x"))
    assert entered.wait(20)
    assert elapsed(lambda: rig.subscription.end(0.05)) < 1.0
    assert not rig.subscription.end(0.05)
    leave.set()
    delivering.join(20)
    assert rig.subscription.end(0.0)


def test_the_end_may_come_from_within_on_frame() -> None:
    ended: list[bool] = []

    def end(frame: bytes, stamp_ns: int) -> None:
        ended.append(rig.subscription.end(1.0))

    rig = Rig(on_frame=end)
    rig.take(b"x")
    rig.take(b"y")
    assert ended == [True]


def test_whoever_waits_for_the_broker_hears_its_first_answer() -> None:
    subscription = Rig().subscription
    refusal = TransportError("not you")
    assert subscription.await_answer(0.0) is None
    subscription.answer(refusal)
    subscription.answer()
    assert subscription.await_answer(0.0) is refusal


def test_waiting_for_the_broker_ends_with_its_answer() -> None:
    subscription = Rig().subscription
    waiting = started(lambda: subscription.await_answer(20.0))
    subscription.answer()
    wait_until(lambda: not waiting.is_alive(), "the end of the waiting", timeout_s=5.0)


def test_a_topic_that_is_none_is_counted_said_once_and_no_sign_of_life(
    caplog: pytest.LogCaptureFixture,
) -> None:
    rig = Rig(is_filter=True)
    for number in range(100):
        rig.take(b"{}", topic=f"lab/\x1b[2J\n{number}", fault="bad_topic")
    assert rig.tally.frame_errors == {"bad_topic": 100}
    assert rig.tally.last_data_ns is None
    assert caplog.messages == [r"dropping messages to a topic MQTT forbids: lab/\x1b[2J\n0"]
    rig.take(b"{}", topic="lab/\u202eumi")
    assert len(rig.frames) == 1


def test_a_fault_of_the_packet_counts_where_the_topic_is_ours() -> None:
    rig = Rig(is_filter=True)
    rig.take(b"{}")
    rig.take(b"", fault="overlong")
    rig.take(b"", fault="duplicate")
    rig.take(b"", fault="overlong", topic="b/imu")
    rig.take(b"", fault="overlong", retained=True)
    assert rig.tally.frame_errors == {
        "overlong": 1, "duplicate": 1, "other_topic": 1, "retained": 1,
    }  # fmt: skip


def test_messages_that_were_read_together_have_stamps_that_rise() -> None:
    rig = Rig()
    rig.take(b"1", b"2", b"3", b"4")
    assert [frame for frame, _ in rig.frames] == [b"1", b"2", b"3", b"4"]
    stamps = [stamp_ns for _, stamp_ns in rig.frames]
    assert stamps == sorted(set(stamps))
    assert rig.subscription.kept == 0


def test_messages_that_are_too_long_to_be_kept_together_are_handed_over_before() -> None:
    rig = Rig()
    most = b"x" * MAX_PAYLOAD_BYTES
    read_ns = rig.stamper.read()
    for _ in range(20):
        rig.keep(most, read_ns)
        assert rig.subscription.kept * MAX_PAYLOAD_BYTES <= 600_000
    rig.subscription.deliver(read_ns)
    stamps = [stamp_ns for _, stamp_ns in rig.frames]
    assert len(stamps) == 20
    assert stamps == sorted(set(stamps))


def test_what_is_no_frame_takes_no_place_among_the_stamps() -> None:
    alone, among = Rig(), Rig()
    for rig, payloads in ((alone, [b"1", b"2"]), (among, [b"1", b"", b"\0", b"2"])):
        for _ in range(20):
            rig.take(*payloads)
        assert len(rig.frames) == 40
    assert among.tally.frame_errors == {"empty": 40}


def test_of_messages_that_were_read_together_the_first_sample_locks_the_topic() -> None:
    rig = Rig(is_filter=True)
    read_ns = rig.stamper.read()
    for payload, topic in ((b"1", "a/imu"), (b"2", "b/imu"), (b"3", "a/imu")):
        rig.keep(payload, read_ns, topic=topic)
    rig.subscription.deliver(read_ns)
    assert [frame for frame, _ in rig.frames] == [b"1", b"3"]
    assert rig.tally.frame_errors == {"other_topic": 1}
