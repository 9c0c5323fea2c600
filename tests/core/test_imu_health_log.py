"""The reader's health in its log, its diagnostics and the live line: the same words everywhere."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rosbase.cli.report import status_line, summary_lines
from rosbase.errors import DeviceNotFoundError
from rosbase.imu.health import HealthLevel
from rosbase.messages import DiagnosticArray, DiagnosticStatus
from support.reader_rig import Rig
from support.samples import GOOD_FRAME, payload, vector

HEARTBEAT = b"heartbeat"
TEMPERATURE = b'{"temp":21.5}'
SKETCH = {"accel_x": 0, "accel_y": 0, "accel_z": 9.8, "gyro_x": 0, "gyro_y": 0, "gyro_z": 0}


class Watched(Rig):
    """A reader, what a device sends it at some rate, and what it says on /diagnostics."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.reported: list[DiagnosticStatus] = []
        self.backend.create_subscription(
            DiagnosticArray, "/diagnostics", lambda m: self.reported.extend(m.status), 100
        )

    def play(self, frame: bytes | dict[str, Any], rate_hz: float, seconds: float) -> None:
        """Have the device send that, again and again."""
        for _ in range(round(rate_hz * seconds)):
            self.send(frame)
            self.pass_time(1 / rate_hz)

    def play_bytes(self, count: int, rate_hz: float, seconds: float) -> None:
        """Have it send bytes of which the transport makes no frame."""
        for _ in range(round(rate_hz * seconds)):
            self.transport.pending_bytes += count
            self.transport.last_data_ns = self.clock.monotonic_ns()
            self.pass_time(1 / rate_hz)


@pytest.fixture
def rigs(caplog: pytest.LogCaptureFixture) -> Iterator[Callable[..., Watched]]:
    caplog.set_level("INFO", logger="rosbase")
    made: list[Watched] = []

    def make(**options: Any) -> Watched:
        made.append(Watched(**options).activate())
        return made[-1]

    yield make
    for rig in made:
        rig.backend.close()


def health_lines(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [message for message in caplog.messages if message.startswith("health")]


@pytest.mark.parametrize("rate_hz", [0.5, 2.0, 4.0, 9.0, 11.0, 50.0, 200.0])
def test_json_of_another_kind_is_said_once_at_any_rate(
    rigs: Callable[..., Watched], caplog: pytest.LogCaptureFixture, rate_hz: float
) -> None:
    rig = rigs(preset="mpu6050")
    rig.pass_time(1 / rate_hz)
    rig.play(TEMPERATURE, rate_hz, 20.0)
    usable = [line for line in health_lines(caplog) if "no data" not in line]
    assert usable == [
        "health WARN: nothing usable arrives: no_imu_data: "
        "nothing that the mapping knows; is the preset right? "
        "angular_velocity: the payload has no 'gyro_x', but 'temp'"
    ]
    rig.play(SKETCH, 100.0, 1.0)
    assert rig.reader.health.level is HealthLevel.OK
    assert health_lines(caplog)[-1] == "health OK: samples arrive"


def test_a_heartbeat_twice_a_second_after_good_samples_is_a_warning(
    rigs: Callable[..., Watched], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs()
    rig.play(GOOD_FRAME, 50.0, 3.0)
    rig.play(HEARTBEAT, 2.0, 10.0)
    assert rig.reader.health.level is HealthLevel.WARN
    assert health_lines(caplog) == [
        "health OK: samples arrive",
        "health WARN: nothing usable arrives: not_data: text that is not JSON",
    ]


def test_a_sensor_that_stops_while_its_board_goes_on_is_a_warning(
    rigs: Callable[..., Watched],
) -> None:
    # An MPU6050 whose bus hangs: the sketch prints on, without numbers.
    rig = rigs(preset="mpu6050")
    rig.play(SKETCH, 50.0, 2.0)
    rig.play({**SKETCH, "accel_x": None, "accel_y": None, "accel_z": None}, 5.0, 3.0)
    assert rig.reader.health.level is HealthLevel.WARN
    assert rig.reader.health.message.startswith("nothing usable arrives: ")


def test_frames_that_are_all_implausible_are_a_warning_that_says_so(
    rigs: Callable[..., Watched],
) -> None:
    rig = rigs(plausibility="reject")
    rig.play(payload(linear_acceleration=vector(z=0.0)), 50.0, 5.0)
    assert rig.reader.health.message.startswith("nothing usable arrives: implausible: ")


def test_bytes_without_an_end_of_line_are_said_counted_and_logged_like_any_reason(
    rigs: Callable[..., Watched], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs()
    rig.play_bytes(25, 20.0, 3.0)
    assert rig.reader.health.level is HealthLevel.WARN
    assert rig.reader.health.message == (
        "nothing usable arrives: unended: 1500 bytes without an end of line; is it the right wire?"
    )
    assert rig.reader.counts.by_reason == {"unended": 1}
    assert rig.reader.counts.rejected == 1
    rig.play_bytes(25, 20.0, 20.0)
    assert len(health_lines(caplog)) == 1
    assert [m for m in caplog.messages if m.startswith("no frame")] == [
        "no frame in the last 625 bytes: unended (bytes without an end of line; "
        "is it the right wire?); 1 so far"
    ]
    assert rig.reader.counts.by_reason == {"unended": 1}, "it is one line that does not end"


def test_each_line_that_does_not_end_is_counted_once(rigs: Callable[..., Watched]) -> None:
    rig = rigs()
    for number in range(3):
        rig.play_bytes(25, 20.0, 3.0)
        rig.transport.pending_bytes = 0
        rig.send(GOOD_FRAME if number == 0 else HEARTBEAT)
    rig.pass_time(0.3)
    assert rig.reader.counts.by_reason == {"unended": 3, "not_data": 2}


def test_what_the_transport_drops_is_logged_at_the_rate_of_what_the_reader_drops(
    rigs: Callable[..., Watched], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs()
    for number in range(1, 101):
        rig.transport.frame_errors = {"overlong": number, "checksum": 2}
        rig.transport.last_data_ns = rig.clock.monotonic_ns()
        rig.pass_time(0.1)
    dropped = [m for m in caplog.messages if m.startswith("dropped")]
    assert dropped == [
        "dropped 3 frames: overlong (too long for a sample; is it the right wire?); 3 so far",
        "dropped 2 frames: checksum; 2 so far",
        dropped[2],
    ]
    assert dropped[2].startswith("dropped 50 frames: overlong")
    assert rig.reader.health.message.startswith("nothing usable arrives: overlong: too long")
    levels = {r.message: r.levelname for r in caplog.records}
    assert levels[dropped[0]] == "WARNING"


def test_what_a_transport_ignores_is_no_warning(
    rigs: Callable[..., Watched], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs()
    rig.transport.frame_errors = {"retained": 1}
    rig.pass_time(0.3)
    (record,) = [r for r in caplog.records if r.message.startswith("dropped 1 frame: retained")]
    assert record.levelname == "INFO"


def test_what_the_transport_has_said_of_a_stall_is_not_said_again(
    rigs: Callable[..., Watched], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs()
    rig.transport.frame_errors = {"late": 320}
    rig.pass_time(0.3)
    assert [m for m in caplog.messages if "late" in m] == []
    assert rig.reader.counts.by_reason == {"late": 320}


def test_what_was_dropped_before_the_activation_is_not_said_again(
    rigs: Callable[..., Watched], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs()
    rig.transport.frame_errors = {"overlong": 2}
    rig.pass_time(0.3)
    rig.reader.trigger_deactivate()
    rig.reader.trigger_activate()
    rig.pass_time(20.0)
    assert len([m for m in caplog.messages if m.startswith("dropped")]) == 1
    assert "overlong" not in rig.reader.health.message


def test_a_finding_whose_figures_change_is_one_line(
    rigs: Callable[..., Watched], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs()
    for number in range(10):
        rig.play(payload(linear_acceleration=vector(z=1.0 + number / 100)), 50.0, 1.0)
    assert len([line for line in health_lines(caplog) if "in g?" in line]) == 1


def test_the_log_the_diagnostics_and_the_live_line_say_the_same(
    rigs: Callable[..., Watched], caplog: pytest.LogCaptureFixture
) -> None:
    def said(rig: Watched) -> str:
        health = rig.reader.health
        rig.reported.clear()
        rig.pass_time(1.0)
        (status,) = rig.reported
        shown = status_line(rig.reader, None, 0, 0.0)
        assert (status.level, status.message) == (health.level, health.message)
        assert shown.startswith(f"{health.level.name} {health.message}  ")
        assert f"health {health.level.name}: {health.message}" == health_lines(caplog)[-1]
        return health.message

    rig = rigs()
    rig.play(HEARTBEAT, 2.0, 3.0)
    assert said(rig).startswith("nothing usable arrives: not_data")
    rig.transport.failure = DeviceNotFoundError("/dev/x is not there")
    rig.pass_time(0.3)
    assert said(rig) == "/dev/x is not there"


def test_the_first_sample_is_ok_on_diagnostics_and_the_live_line_within_a_second(
    rigs: Callable[..., Watched],
) -> None:
    # Sent at each moment between two looks and two reports.
    for delay_ms in range(0, 1000, 90):
        rig = rigs()
        rig.pass_time(3.0 + delay_ms / 1000)
        assert status_line(rig.reader, None, 0, 0.0).startswith("WARN no data for ")
        rig.reported.clear()
        rig.play(GOOD_FRAME, 50.0, 1.0)
        assert rig.reported[-1].level == DiagnosticStatus.OK
        assert rig.reported[-1].message == "samples arrive"
        assert "WARN" not in status_line(rig.reader, None, 0, 0.0)
        rig.reader.trigger_deactivate()


def test_it_is_ok_while_samples_flow_and_the_diagnostics_say_how_many_are_rejected(
    rigs: Callable[..., Watched],
) -> None:
    rig = rigs()
    rig.pass_time(1.0)
    for _ in range(10):
        rig.send(GOOD_FRAME)
        for _ in range(5):
            rig.send(b"{}")
        rig.pass_time(0.1)
    status = rig.reported[-1]
    assert (status.level, status.message) == (DiagnosticStatus.OK, "samples arrive")
    values = {pair.key: pair.value for pair in status.values}
    assert (values["rate (Hz)"], values["rejected rate (Hz)"]) == ("10.0", "50.0")


def test_the_summary_ends_with_what_was_wrong_at_the_end(rigs: Callable[..., Watched]) -> None:
    rig = rigs()
    rig.play(GOOD_FRAME, 50.0, 2.0)
    rig.reader.trigger_deactivate()
    assert rig.reader.health.message == "not active"
    assert not [line for line in summary_lines(rig.reader, 0, None) if line.startswith("health")]
    rig.reader.trigger_activate()
    rig.play(HEARTBEAT, 2.0, 3.0)
    rig.reader.trigger_shutdown()
    *_, last = summary_lines(rig.reader, 0, None)
    assert last == ("health WARN nothing usable arrives: not_data: text that is not JSON")


def test_a_reader_that_is_not_active_has_no_health_to_check(rigs: Callable[..., Watched]) -> None:
    rig = rigs()
    rig.pass_time(3.0)
    rig.reader.trigger_deactivate()
    assert rig.reader.check_health() == rig.reader.health
    assert rig.reader.health.level is HealthLevel.OK


def test_activating_again_begins_again(rigs: Callable[..., Watched]) -> None:
    rig = rigs()
    rig.play(HEARTBEAT, 2.0, 3.0)
    rig.reader.trigger_deactivate()
    rig.pass_time(100.0)
    rig.reader.trigger_activate()
    rig.pass_time(0.3)
    assert rig.reader.health.message == "waiting for the first sample"
