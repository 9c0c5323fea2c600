"""The reader node, with a transport that the test plays."""

import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, cast

import pytest

from rosbase.contracts.backend import BackendOptions
from rosbase.contracts.transport import TransportState
from rosbase.errors import (
    BackendError,
    ConfigurationError,
    DeviceNotFoundError,
    MappingError,
    NotInstalledError,
    ParameterError,
    TransportError,
)
from rosbase.imu.health import HealthLevel
from rosbase.imu.reader import ImuReader
from rosbase.lifecycle import CallbackReturn, State
from rosbase.local import Bus, LocalBackend
from rosbase.messages import Imu, Time
from rosbase.parameters import Parameter
from rosbase.plugins import installed_plugins
from rosbase.testing import ManualClock
from support.reader_rig import Rig
from support.samples import (
    FAULTS,
    GOOD,
    GOOD_DATE_NS,
    GOOD_FRAME,
    ORIENTATION_FAULTS,
    payload,
    vector,
)
from support.transports import ScriptedRegistry


@pytest.fixture
def rigs() -> Iterator[Callable[..., Rig]]:
    made: list[Rig] = []

    def make(**options: Any) -> Rig:
        made.append(Rig(**options))
        return made[-1]

    yield make
    for rig in made:
        rig.backend.close()


def test_a_good_frame_becomes_imu_data(rigs: Callable[..., Rig]) -> None:
    ((topic, message),) = rigs().activate().send(GOOD_FRAME, stamp_ns=1_000_000_002)
    assert topic == "data"
    assert message.header.stamp == Time(1, 2)
    assert message.header.frame_id == "imu_link"
    assert message.angular_velocity.y == -0.2
    assert message.linear_acceleration.z == 9.80665
    assert message.orientation_covariance == (0.0,) * 9


def test_without_orientation_it_is_data_raw_and_says_so(rigs: Callable[..., Rig]) -> None:
    ((topic, message),) = rigs().activate().send(payload(orientation={}))
    assert topic == "data_raw"
    assert message.orientation_covariance[0] == -1.0
    assert message.angular_velocity_covariance == (0.0,) * 9


def test_minus_one_stands_exactly_on_what_is_not_reported(rigs: Callable[..., Rig]) -> None:
    rig = rigs(
        **{
            "preset": "custom",
            "mapping.linear_acceleration.paths": ["a"],
            "mapping.linear_acceleration.unit": "g",
            "mapping.orientation.paths": ["q"],
            "orientation_stddev": [0.1],
            "linear_acceleration_stddev": [1.0, 2.0, 3.0],
        }
    ).activate()
    ((topic, message),) = rig.send({"q": [0, 0, 0, 1]})
    assert topic == "data"
    assert message.orientation_covariance[::4] == pytest.approx((0.01, 0.01, 0.01))
    assert message.angular_velocity_covariance[0] == -1.0
    assert message.linear_acceleration_covariance[0] == -1.0
    ((topic, message),) = rig.send({"a": [0, 1, 0]})
    assert topic == "data_raw"
    assert message.linear_acceleration.y == 9.80665
    assert message.linear_acceleration_covariance == (1, 0, 0, 0, 4, 0, 0, 0, 9)
    assert message.orientation_covariance[0] == -1.0


def test_a_magnetic_field_goes_to_its_own_topic_with_the_same_stamp(
    rigs: Callable[..., Rig],
) -> None:
    rig = rigs(preset="waveshare_ugv", magnetic_field_stddev=[1e-6]).activate()
    line = {"T": 1002, "ax": 0, "ay": 0, "az": 9.8, "gx": 0, "gy": 0, "gz": 0}
    first, second = rig.send({**line, "mx": 20, "my": 0, "mz": 40})
    assert {first[0], second[0]} == {"data_raw", "mag"}
    assert first[1].header == second[1].header
    field = dict([first, second])["mag"]
    assert field.magnetic_field.x == pytest.approx(20e-6)
    assert field.magnetic_field_covariance[0] == pytest.approx(1e-12)
    assert rig.reader.counts.published == 1


@pytest.mark.parametrize("fault", FAULTS)
def test_a_bad_frame_is_dropped_counted_and_the_next_goes_through(
    rigs: Callable[..., Rig], fault: str
) -> None:
    rig = rigs().activate()
    line, reason = FAULTS[fault]
    assert rig.send(line) == []
    assert len(rig.send(GOOD_FRAME)) == 1
    counts = rig.reader.counts
    assert counts.by_reason == {reason: 1}
    assert counts.received == counts.published + counts.rejected + counts.ignored == 2


@pytest.mark.parametrize("fault", ORIENTATION_FAULTS)
def test_a_bad_orientation_is_left_out_counted_and_said(
    rigs: Callable[..., Rig], fault: str, caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs().activate()
    line, reason = ORIENTATION_FAULTS[fault]
    ((topic, message),) = rig.send(line)
    assert topic == "data_raw"
    assert message.orientation_covariance[0] == -1.0
    counts = rig.reader.counts
    assert counts.left_out == {reason: 1}
    assert (counts.published, counts.received) == (1, 1)
    (said,) = [m for m in caplog.messages if m.startswith("used only part of")]
    assert reason in said


def test_a_flood_of_bad_frames_is_one_line_in_the_log(
    rigs: Callable[..., Rig], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs().activate()
    for _ in range(100):
        rig.send(FAULTS["P2 NaN"][0])
        rig.clock.advance(0.01)
    dropped = [message for message in caplog.messages if message.startswith("dropped")]
    assert len(dropped) == 1
    assert "\n" not in dropped[0]
    assert len(dropped[0]) < 200


def test_the_device_time_is_used_if_asked_for_and_usable(rigs: Callable[..., Rig]) -> None:
    rig = rigs(time_source="device").activate()
    ((_, message),) = rig.send(GOOD_FRAME, stamp_ns=GOOD_DATE_NS + 10**6)
    assert message.header.stamp == Time(1_700_000_000, 5)
    uptime = {"header": {"stamp": {"secs": 12, "nsecs": 34}}}
    ((_, message),) = rig.send(payload(**uptime), stamp_ns=GOOD_DATE_NS + 10**9)
    assert message.header.stamp == Time(1_700_000_001, 5)
    assert rig.reader.counts.time_unusable == 1
    ((_, message),) = rigs().activate().send(GOOD_FRAME, stamp_ns=10**9)
    assert message.header.stamp == Time(1, 0), "by default it is the arrival"


def test_m8_stamps_of_the_device_neither_repeat_nor_go_back(rigs: Callable[..., Rig]) -> None:
    rig = rigs(time_source="device").activate()
    assert rig.send(GOOD_FRAME, GOOD_DATE_NS)
    assert not rig.send(GOOD_FRAME, GOOD_DATE_NS)
    early = {"header": {"stamp": {"secs": 1_699_999_999, "nsecs": 0}}}
    assert not rig.send(payload(**early), GOOD_DATE_NS)
    assert rig.reader.counts.by_reason == {"duplicate": 1, "out_of_order": 1}


def test_wrong_units_are_said_and_never_mended(
    rigs: Callable[..., Rig], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs().activate()
    for _ in range(60):
        ((_, message),) = rig.send(payload(linear_acceleration=vector(z=1.0)))
        assert message.linear_acceleration.z == 1.0
    rig.pass_time(0.6)
    assert rig.reader.health.level is HealthLevel.WARN
    assert any("are the numbers in g?" in message for message in caplog.messages)


def test_implausible_samples_are_refused_by_option(rigs: Callable[..., Rig]) -> None:
    rig = rigs(plausibility="reject").activate()
    for _ in range(60):
        rig.send(payload(linear_acceleration=vector(z=0.0)))
    assert rig.reader.counts.by_reason["implausible"] == 11
    quiet = rigs(plausibility="off").activate()
    for _ in range(60):
        quiet.send(payload(linear_acceleration=vector(z=0.0)))
    assert quiet.reader.counts.published == 60


def test_the_lifecycle_drives_the_transport(rigs: Callable[..., Rig]) -> None:
    rig = rigs(gain=2.5)
    reader = rig.reader
    reader.trigger_configure()
    transport = rig.transport
    assert transport.values == {"gain": 2.5}
    assert transport.calls == ["open"]
    reader.trigger_activate()
    reader.trigger_deactivate()
    assert transport.calls == ["open", "open", "start", "close"]
    reader.trigger_activate()
    assert len(rig.send(GOOD_FRAME)) == 1
    reader.trigger_deactivate()
    reader.trigger_cleanup()
    reader.trigger_configure()
    assert rig.transport is not transport
    reader.trigger_shutdown()
    assert rig.transport.calls[-1] == "close"
    assert reader.get_state() is State.FINALIZED


def test_a_device_that_cannot_be_had_is_failure_in_one_line(
    rigs: Callable[..., Rig], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs(failure=DeviceNotFoundError("/dev/x is not there"))
    assert rig.reader.trigger_configure() is CallbackReturn.FAILURE
    assert rig.reader.get_state() is State.UNCONFIGURED
    assert caplog.messages == ["configure failed, now unconfigured: /dev/x is not there"]
    assert caplog.records[0].exc_info is None
    rig.registry.failure = None
    rig.activate()


def test_a_device_lost_before_activation_is_failure_and_leaves_it_inactive(
    rigs: Callable[..., Rig],
) -> None:
    rig = rigs()
    rig.reader.trigger_configure()
    rig.transport.failure = DeviceNotFoundError("/dev/x is not there")
    assert rig.reader.trigger_activate() is CallbackReturn.FAILURE
    assert rig.reader.get_state() is State.INACTIVE
    rig.transport.failure = None
    assert rig.reader.trigger_activate() is CallbackReturn.SUCCESS


def test_silence_is_warn_then_error_then_ok_again(
    rigs: Callable[..., Rig], caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO", logger="rosbase")
    rig = rigs(stale_timeout=1.0).activate()
    levels = []
    for _ in range(14):
        rig.pass_time(0.5)
        levels.append(rig.reader.health.level.name)
    assert levels == ["OK"] * 2 + ["WARN"] * 8 + ["ERROR"] * 4
    rig.send(GOOD_FRAME)
    rig.pass_time(0.5)
    assert rig.reader.health.level is HealthLevel.OK
    assert len([m for m in caplog.messages if m.startswith("health")]) == 3


def test_a_lost_device_is_error_with_the_reason(rigs: Callable[..., Rig]) -> None:
    rig = rigs().activate()
    rig.transport.state = TransportState.RECONNECTING
    rig.transport.failure = DeviceNotFoundError("/dev/x is not there")
    rig.pass_time(0.5)
    assert rig.reader.health.level is HealthLevel.ERROR
    assert rig.reader.health.message == "waiting for the device: /dev/x is not there"


def test_a_device_that_comes_and_goes_stays_error_though_data_come_in_between(
    rigs: Callable[..., Rig], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs().activate()
    fault = TransportError("the connection is lost again and again")
    for turn in range(6):
        is_away = turn % 2 == 0
        rig.transport.state = TransportState.RECONNECTING if is_away else TransportState.CONNECTED
        rig.transport.failure = fault
        if not is_away:
            rig.send(GOOD_FRAME)
        rig.pass_time(0.5)
        assert rig.reader.health.level is HealthLevel.ERROR
        assert str(fault) in rig.reader.health.message
    assert len([m for m in caplog.messages if m.startswith("health")]) == 1
    rig.transport.failure = None
    rig.pass_time(0.5)
    assert rig.reader.health.level is HealthLevel.OK


def test_nothing_but_noise_is_warn_and_says_what_the_transport_says_of_it(
    rigs: Callable[..., Rig],
) -> None:
    rig = rigs().activate()
    for _ in range(5):
        rig.send(b"\xff\xfe")
        rig.pass_time(0.3)
    assert rig.reader.health.level is HealthLevel.WARN
    assert rig.reader.health.message.endswith("not_utf8: bytes that are not text; check the wire")


def test_health_says_the_cause_that_the_bytes_show(rigs: Callable[..., Rig]) -> None:
    rig = rigs().activate()
    for _ in range(5):
        rig.send(b"12:00:01.250 -> " + GOOD_FRAME)
        rig.pass_time(0.3)
    assert "not_data: JSON behind '12:00:01.250 -> '" in rig.reader.health.message


def test_what_the_transport_could_not_frame_is_explained_by_the_transport(
    rigs: Callable[..., Rig],
) -> None:
    rig = rigs().activate()
    rig.pass_time(0.5)
    rig.transport.frame_errors = {"overlong": 9}
    for _ in range(5):
        rig.send(b"\xff")
        rig.pass_time(0.3)
    assert rig.reader.health.message.endswith("too long for a sample; is it the right wire?")


def test_frame_errors_of_the_transport_count_as_rejected(rigs: Callable[..., Rig]) -> None:
    rig = rigs().activate()
    rig.transport.frame_errors = {"overlong": 2}
    assert rig.reader.counts.by_reason == {"overlong": 2}
    assert rig.reader.counts.received == 2
    rig.reader.trigger_deactivate()
    rig.reader.trigger_cleanup()
    rig.reader.trigger_configure()
    assert rig.reader.counts.by_reason == {"overlong": 2}, "counts outlive the transport"


@pytest.mark.parametrize(
    ("parameters", "kind", "complaint"),
    [
        ({"comm_t": "mqtt"}, NotInstalledError, "pip install imu-mqtt"),
        ({"preset": "mpu6O50"}, NotInstalledError, "did you mean 'mpu6050'"),
        ({"frame_id": 5}, ParameterError, "frame_id takes text"),
        ({"stale_timeout": 0.0}, ParameterError, "stale_timeout is at least"),
        ({"orientation_stddev": [1.0, 2.0]}, ParameterError, "one number or three"),
        ({"angular_velocity_stddev": [1e200]}, ParameterError, "too large"),
        ({"preset": "custom"}, MappingError, "names no quantity"),
        (
            {"mapping.orientation.paths": ["<preset>", "b", "c", "d"]},
            ParameterError,
            "must be the only element",
        ),
        ({"preset": "mpu6050", "time_source": "device"}, MappingError, "time.paths is empty"),
        (
            {"mapping.angular_velocity.paths": ["gx", "gy", "gz"]},
            MappingError,
            "angular_velocity.unit must be stated",
        ),
    ],
)
def test_parameters_that_cannot_be_are_refused_when_the_node_is_built(
    rigs: Callable[..., Rig], parameters: Any, kind: type[ConfigurationError], complaint: str
) -> None:
    with pytest.raises(kind, match=complaint):
        rigs(**parameters)


def fails_with(error: Exception) -> Callable[[], Any]:
    def fail() -> None:
        raise error

    return fail


CREATES: dict[str, tuple[Callable[[], Any], str]] = {
    "refuses": (fails_with(ParameterError("gain is odd")), "gain is odd"),
    "is not written": (
        fails_with(NotImplementedError("step 2")),
        "'scripted' is not finished: step 2",
    ),
    "fails": (fails_with(KeyError("x")), "'scripted' is broken: KeyError('x')"),
    "gives nothing": (lambda: None, "'scripted' is broken: create gave None"),
}


@pytest.mark.parametrize(("create", "complaint"), CREATES.values(), ids=CREATES)
def test_a_transport_that_cannot_be_made_is_refused_when_the_node_is_built(
    create: Callable[[], Any], complaint: str
) -> None:
    registry = ScriptedRegistry(installed_plugins())
    registry.create = create
    backend = LocalBackend(BackendOptions("imu", {"comm_t": "scripted"}, ManualClock()), Bus())
    with pytest.raises(ConfigurationError, match=re.escape(complaint)):
        ImuReader(backend=backend, registry=cast("Any", registry))
    backend.close()


def test_a_device_that_is_not_written_yet_is_failure_in_one_line(rigs: Callable[..., Rig]) -> None:
    rig = rigs(failure=NotImplementedError("step 3"))
    assert rig.reader.trigger_configure() is CallbackReturn.FAILURE
    assert str(rig.reader.last_error) == "transport 'scripted' is not finished: step 3"


@pytest.mark.parametrize("error", [KeyboardInterrupt(), MemoryError(), BackendError("no")])
def test_whatever_ends_configure_the_device_is_closed(
    rigs: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    rig = rigs()
    opened: list[bool] = []

    def fail(*arguments: Any) -> None:
        opened.append(rig.transport.is_open)
        raise error

    monkeypatch.setattr(rig.backend, "create_publisher", fail)
    with suppress(KeyboardInterrupt):
        rig.reader.trigger_configure()
    assert opened == [True]
    assert not rig.transport.is_open
    assert rig.reader.get_state() is State.UNCONFIGURED


def test_a_device_that_was_refused_is_not_what_it_is_said_to_be(rigs: Callable[..., Rig]) -> None:
    rig = rigs()
    assert rig.backend.set_parameters([Parameter("gain", 7.0)]).successful
    rig.registry.create = fails_with(ParameterError("gain is odd"))
    assert rig.reader.trigger_configure() is CallbackReturn.FAILURE
    assert rig.reader.settings.device == "1.0"


def test_other_paths_with_their_unit_replace_those_of_the_preset(
    rigs: Callable[..., Rig],
) -> None:
    rig = rigs(
        **{
            "mapping.angular_velocity.paths": ["gx", "gy", "gz"],
            "mapping.angular_velocity.unit": "deg/s",
        }
    ).activate()
    ((_, message),) = rig.send({**GOOD, "gx": 0, "gy": 0, "gz": 90})
    assert message.angular_velocity.z == pytest.approx(1.5708, abs=1e-4)


def test_an_empty_list_takes_away_what_the_preset_says(rigs: Callable[..., Rig]) -> None:
    accel_only = payload(orientation=None, angular_velocity=None)
    ((topic, message),) = rigs(**{"mapping.required": []}).activate().send(accel_only)
    assert (topic, message.angular_velocity_covariance[0]) == ("data_raw", -1.0)
    ((topic, _),) = rigs(**{"mapping.orientation.paths": []}).activate().send(GOOD_FRAME)
    assert topic == "data_raw"
    untagged = {"ax": 0, "ay": 0, "az": 9.8, "gx": 0, "gy": 0, "gz": 0}
    rig = rigs(preset="waveshare_ugv", **{"mapping.select": []}).activate()
    assert len(rig.send(untagged)) == 1


def test_the_topics_can_be_moved_together(rigs: Callable[..., Rig]) -> None:
    rig = rigs(topic_namespace="left/imu")
    got: list[Imu] = []
    rig.backend.create_subscription(Imu, "/left/imu/data", got.append, 1)
    rig.activate().send(GOOD_FRAME)
    assert len(got) == 1


@pytest.mark.parametrize("source", ["device", "arrival"])
def test_a_transport_is_told_whether_frames_carry_dates(
    rigs: Callable[..., Rig], source: str
) -> None:
    rig = rigs(time_source=source).activate()
    assert rig.transport.context.frames_are_dated == (source == "device")
