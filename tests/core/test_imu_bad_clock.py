"""A date of the machine that ROS cannot carry costs the stamps, not the reader."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rosbase import BackendOptions, LifecycleNode, date_fault
from rosbase.cli.monitor import SampleMonitor
from rosbase.cli.report import summary_lines
from rosbase.imu.health import HealthLevel
from rosbase.lifecycle import CallbackReturn
from rosbase.local import Bus, LocalBackend
from rosbase.messages import (
    STAMPS_END_NS,
    DiagnosticArray,
    Header,
    Imu,
    MagneticField,
    String,
    Time,
    is_stamp,
)
from rosbase.testing import ManualClock
from support.reader_rig import Rig
from support.samples import GOOD, GOOD_FRAME, frame

S = 1_000_000_000
NOW_NS = 1_800_000_000 * S
Y2040_NS = 2_208_988_800 * S
Y1969_NS = -18_489_600 * S
BAD_DATES_NS = {
    "2040": Y2040_NS,
    "1969": Y1969_NS,
    "the second after the last": STAMPS_END_NS,
    "the nanosecond before the first": -1,
    "no date": 0,
    "2110, when 32 bits without a sign are over too": 4_417_977_600 * S,
    "the year 12000": 316_516_000_000 * S,
}
FIELD_MAPPING = {
    "mapping.magnetic_field.paths": ["mag.x", "mag.y", "mag.z"],
    "mapping.magnetic_field.unit": "T",
}
FIELD = {"x": 2e-5, "y": 0.0, "z": -4e-5}


@pytest.fixture
def rigs() -> Iterator[Callable[..., Rig]]:
    made: list[Rig] = []

    def make(date_ns: int, **parameters: Any) -> Rig:
        rig = Rig(**parameters)
        made.append(rig)
        rig.clock.date_ns = date_ns
        return rig.activate()

    yield make
    for rig in made:
        rig.backend.close()


def send_now(rig: Rig, data: bytes = GOOD_FRAME) -> list[Any]:
    """The messages that a frame becomes which arrives now."""
    return [message for _, message in rig.send(data, rig.clock.now_ns())]


@given(st.integers(-(2**70), 2**70))
@example(-1)
@example(0)
@example(STAMPS_END_NS - 1)
@example(STAMPS_END_NS)
def test_a_stamp_is_the_time_or_zero_and_always_fits_into_that_of_ros(nanoseconds: int) -> None:
    stamp = Time.as_stamp(nanoseconds)
    assert is_stamp(nanoseconds) is (0 < nanoseconds < 2**31 * S)
    assert stamp == (Time.from_nanoseconds(nanoseconds) if is_stamp(nanoseconds) else Time())
    assert 0 <= stamp.sec < 2**31
    assert 0 <= stamp.nanosec < S
    assert bool(date_fault(nanoseconds)) is not is_stamp(nanoseconds)
    assert "\n" not in date_fault(nanoseconds)


def test_a_date_that_cannot_be_a_stamp_is_named() -> None:
    assert date_fault(Y2040_NS) == (
        "the date of this machine is 2040-01-01 00:00:00 UTC,"
        " and ROS stamps go from 1970 to 2038-01-19"
    )
    assert "is 1969-06-01 00:00:00 UTC," in date_fault(Y1969_NS)
    assert "is 3.17e+11 s after 1970," in date_fault(316_516_000_000 * S)
    assert date_fault(0) == (
        "the clock has no date yet; with use_sim_time, does anything publish /clock?"
    )


@pytest.mark.parametrize("date_ns", BAD_DATES_NS.values(), ids=BAD_DATES_NS)
def test_samples_go_out_with_a_stamp_of_zero_and_are_counted(
    rigs: Callable[..., Rig], date_ns: int
) -> None:
    rig = rigs(date_ns, **FIELD_MAPPING)
    sample, field = send_now(rig, frame(mag=FIELD))
    assert isinstance(sample, Imu)
    assert isinstance(field, MagneticField)
    assert sample.header.stamp == field.header.stamp == Time()
    assert sample.linear_acceleration.z == GOOD["linear_acceleration"]["z"]
    send_now(rig)
    counts = rig.reader.counts
    assert (counts.published, counts.clock_unusable) == (2, 2)
    assert (counts.rejected, counts.ignored, counts.by_reason) == (0, 0, {})
    assert "clock_unusable 2" in list(summary_lines(rig.reader, 0, None))


def test_health_says_so_and_is_well_again_when_the_clock_is_right(
    rigs: Callable[..., Rig], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs(Y2040_NS)
    for _ in range(10):
        send_now(rig)
        rig.pass_time(0.5)
        assert rig.reader.health.level is HealthLevel.WARN
        assert rig.reader.health.message.startswith(
            "stamps are zero: the date of this machine is 2040-01-01 "
        )
    rig.clock.date_ns = NOW_NS
    (sample,) = send_now(rig)
    assert sample.header.stamp == rig.clock.now() != Time()
    rig.pass_time(0.5)
    assert rig.reader.health.level is HealthLevel.OK
    assert rig.reader.counts.clock_unusable == 10
    # A second bad date is said like the first.
    rig.clock.date_ns = Y1969_NS
    send_now(rig)
    rig.pass_time(0.5)
    assert "1969" in rig.reader.health.message
    assert "health WARN: stamps are zero: the date of this machine is 1969" in caplog.text


def test_a_machine_without_a_clock_starts_in_1970_and_its_stamps_follow_when_it_is_set(
    rigs: Callable[..., Rig],
) -> None:
    rig = rigs(5 * S)
    (early,) = send_now(rig)
    assert early.header.stamp.sec == 5
    rig.clock.date_ns = NOW_NS
    (late,) = send_now(rig)
    assert late.header.stamp.sec == NOW_NS // S
    rig.pass_time(0.5)
    assert rig.reader.health.level is HealthLevel.OK
    assert rig.reader.counts.clock_unusable == 0


def test_dates_of_the_device_are_as_good_as_ever(rigs: Callable[..., Rig]) -> None:
    rig = rigs(Y2040_NS, time_source="device")
    (sample,) = send_now(rig)
    assert sample.header.stamp.sec == GOOD["header"]["stamp"]["sec"]
    rig.pass_time(0.5)
    assert rig.reader.health.level is HealthLevel.OK
    # The device's clock is not blamed for what the machine's has wrong.
    for second in range(1, 100):
        rig.pass_time(1.0)
        stamp = {"sec": GOOD["header"]["stamp"]["sec"] + second, "nanosec": second}
        rate = {"x": second / 7, "y": 0.0, "z": 0.0}
        (sample,) = send_now(rig, frame(header={"stamp": stamp}, angular_velocity=rate))
        assert sample.header.stamp.sec == stamp["sec"]
    rig.pass_time(0.5)
    assert rig.reader.health.level is HealthLevel.OK
    assert rig.reader.counts.clock_unusable == 0


def test_a_device_without_dates_has_those_of_the_machine_or_none(
    rigs: Callable[..., Rig],
) -> None:
    rig = rigs(Y2040_NS, time_source="device")
    (sample,) = send_now(rig, frame(header=None))
    assert sample.header.stamp == Time()
    counts = rig.reader.counts
    assert (counts.time_unusable, counts.clock_unusable) == (1, 1)
    rig.pass_time(0.5)
    assert "the date of this machine is 2040" in rig.reader.health.message


@pytest.mark.parametrize("date_ns", [Y2040_NS, Y1969_NS])
def test_diagnostics_go_on_with_a_stamp_of_zero(rigs: Callable[..., Rig], date_ns: int) -> None:
    rig = rigs(date_ns)
    heard: list[DiagnosticArray] = []
    rig.backend.create_subscription(DiagnosticArray, "/diagnostics", heard.append, 10)
    send_now(rig)
    rig.pass_time(1.0)
    (message,) = heard
    assert message.header.stamp == Time()
    values = {pair.key: pair.value for pair in message.status[0].values}
    assert (values["published"], values["clock unusable"]) == ("1", "1")


@pytest.mark.parametrize("date_ns", BAD_DATES_NS.values(), ids=BAD_DATES_NS)
def test_whoever_asks_for_the_time_gets_what_can_be_sent(date_ns: int) -> None:
    backend = LocalBackend(BackendOptions("n", clock=ManualClock(date_ns)), Bus())
    assert backend.clock.now() == Time()
    assert backend.clock.now_ns() == date_ns
    heard: list[Header] = []
    backend.create_subscription(Header, "h", heard.append, 10)
    backend.create_publisher(Header, "h", 10).publish(Header(backend.clock.now().to_msg()))
    while backend.spin_once(0.0):
        pass
    assert heard == [Header()]
    backend.close()


def test_no_latency_is_made_of_a_stamp_that_is_none(rigs: Callable[..., Rig]) -> None:
    rig = rigs(Y2040_NS)
    monitor = SampleMonitor(backend=rig.backend)
    send_now(rig)
    assert (monitor.latency.count, monitor.last is not None) == (0, True)
    rig.clock.date_ns = NOW_NS
    send_now(rig)
    assert monitor.latency.count == 1


class _Refusing:
    """A publisher whose world takes nothing, or raises."""

    def __init__(self, inner: Any, answer: Any) -> None:
        self.inner, self.topic, self.answer = inner, inner.topic, answer

    def publish(self, message: object) -> object:
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


class _RefusingBackend(LocalBackend):
    answer: Any = False

    def create_publisher(self, *arguments: Any) -> Any:
        publisher = super().create_publisher(*arguments)
        return _Refusing(publisher, self.answer) if "imu" in publisher.topic else publisher

    def destroy_publisher(self, publisher: Any) -> None:
        super().destroy_publisher(getattr(publisher, "inner", publisher))


@pytest.fixture
def refusing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("support.reader_rig.LocalBackend", _RefusingBackend)


@pytest.mark.usefixtures("refusing")
def test_a_sample_that_the_world_does_not_take_is_counted_as_not_sent(
    rigs: Callable[..., Rig],
) -> None:
    rig = rigs(NOW_NS, **FIELD_MAPPING)
    assert send_now(rig, frame(mag=FIELD)) == []
    assert send_now(rig) == []
    counts = rig.reader.counts
    assert (counts.published, counts.rejected, counts.by_reason) == (0, 2, {"not_sent": 2})


@pytest.mark.usefixtures("refusing")
def test_health_names_the_date_where_that_is_why_the_world_takes_nothing(
    rigs: Callable[..., Rig], caplog: pytest.LogCaptureFixture
) -> None:
    # The samples are all the same, which is not what is looked at here.
    rig = rigs(Y2040_NS, frozen="off")
    for _ in range(20):
        for _ in range(10):
            send_now(rig)
        rig.pass_time(0.5)
    assert rig.reader.health.level.name == "WARN"
    assert "2040" in rig.reader.health.message
    assert rig.reader.counts.by_reason == {"not_sent": 200}
    # Said once, without a word between that the device gives nothing usable.
    assert len([text for text in caplog.messages if text.startswith("health")]) <= 2
    rig.clock.date_ns = NOW_NS
    for _ in range(10):
        send_now(rig)
        rig.pass_time(0.5)
    assert "nothing usable arrives: not_sent" in rig.reader.health.message


@pytest.mark.usefixtures("refusing")
def test_an_exception_while_publishing_is_counted_and_goes_on_to_whoever_logs_it(
    rigs: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_RefusingBackend, "answer", ValueError("no such stamp"))
    rig = rigs(NOW_NS)
    with pytest.raises(ValueError, match="no such stamp"):
        rig.transport.deliver(GOOD_FRAME, NOW_NS)
    counts = rig.reader.counts
    assert (counts.published, counts.by_reason) == (0, {"not_sent": 1})
    assert counts.received == 1


def test_a_message_that_the_world_does_not_take_is_told_from_one_that_went() -> None:
    class Talker(LifecycleNode):
        def on_configure(self, previous_state: object) -> CallbackReturn:
            self.talk = self.create_publisher(String, "imu_words")
            return CallbackReturn.SUCCESS

    backend = _RefusingBackend(BackendOptions("n"), Bus())
    talker = Talker(backend=backend)
    talker.trigger_configure()
    talker.trigger_activate()
    assert talker.talk.publish(String("x")) is False
    backend.close()
