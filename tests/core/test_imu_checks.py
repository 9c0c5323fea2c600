"""The checks in the reader: each warns or rejects as its parameter says, and heals."""

import json
from collections.abc import Callable, Iterator
from datetime import datetime, timezone
from random import Random
from typing import Any

import pytest

from rosbase.errors import ParameterError
from rosbase.imu.checks.checksum import CHECKSUMS
from rosbase.imu.health import HealthLevel
from support.reader_rig import Rig
from support.samples import GOOD_DATE_NS, payload, vector

S = 1_000_000_000
NOW_NS = 1_780_000_000 * S
FLAT = {
    "preset": "custom",
    "mapping.linear_acceleration.paths": ["acc"],
    "mapping.linear_acceleration.unit": "m/s^2",
    "mapping.angular_velocity.paths": ["gyr"],
    "mapping.angular_velocity.unit": "rad/s",
    "mapping.orientation.paths": ["q"],
    "mapping.time.paths": ["at"],
    "mapping.time.unit": "s",
}


class Device:
    """A device at 20 Hz, whose frames arrive as they are sent."""

    def __init__(self, rig: Rig, rate_hz: float = 20.0) -> None:
        self.rig = rig
        self.now_ns = NOW_NS
        self._period_s = 1.0 / rate_hz
        self._draw = Random(1)

    def noise(self) -> float:
        return round(self._draw.gauss(0.0, 0.02), 4)

    def send(self, make: Callable[[], dict[str, Any] | bytes], seconds: float) -> int:
        """Sends frames for so long; gives how many went out."""
        published = 0
        for _ in range(round(seconds / self._period_s)):
            data = make()
            line = data if isinstance(data, bytes) else json.dumps(data).encode()
            published += bool(self.rig.send(line, self.now_ns))
            self.now_ns += round(self._period_s * S)
            self.rig.pass_time(self._period_s)
        return published

    def at_rest(self, z: float = 9.81, **more: Any) -> dict[str, Any]:
        return {"acc": [self.noise(), self.noise(), z + self.noise()], "gyr": [0, 0, 0.1], **more}

    def moving(self) -> dict[str, Any]:
        x, y, z = (self._draw.gauss(0.0, 3.0) for _ in range(3))
        return {"acc": [x, y, 9.81 + z], "gyr": [self.noise(), 0, 0.1]}

    def dated(self, ahead_ns: int, as_text: bool = False) -> dict[str, Any]:
        date_ns = self.now_ns + ahead_ns
        date = datetime.fromtimestamp(date_ns / S, timezone.utc).isoformat().replace("+00:00", "Z")
        return self.at_rest(at=date if as_text else date_ns / S)


@pytest.fixture
def device() -> Iterator[Callable[..., Device]]:
    made: list[Rig] = []

    def make(**options: Any) -> Device:
        made.append(Rig(**{**FLAT, **options}))
        return Device(made[-1].activate())

    yield make
    for rig in made:
        rig.backend.close()


def health_of(device: Device) -> str:
    health = device.rig.reader.health
    return health.message if health.level is HealthLevel.WARN else ""


def reasons(device: Device) -> dict[str, int]:
    return dict(device.rig.reader.counts.by_reason)


# Gravity


def test_zeros_while_the_sensor_boots_do_not_cost_the_samples_of_a_moving_robot(
    device: Callable[..., Device],
) -> None:
    imu = device(plausibility="reject")
    imu.send(lambda: {"acc": [0, 0, 0], "gyr": [0, 0, 0]}, 3.0)
    assert reasons(imu) == {"implausible": 11}
    imu.send(imu.moving, 7.5)
    assert imu.send(imu.moving, 5.0) == 100


@pytest.mark.parametrize(
    "while_booting",
    [
        {"acc": [-0.0006, -0.0006, -0.0006], "gyr": [0, 0, 0]},
        {"acc": [0, 0, 1.0], "gyr": [0, 0, 0]},
        {"acc": [156.9, 156.9, 156.9], "gyr": [34.9, 34.9, 34.9]},
    ],
)
def test_what_a_bus_gives_that_is_not_ready_is_forgotten_too(
    device: Callable[..., Device], while_booting: dict[str, Any]
) -> None:
    imu = device(plausibility="reject")
    imu.send(lambda: while_booting, 3.0)
    assert reasons(imu)["implausible"] > 0
    imu.send(imu.moving, 10.0)
    assert imu.send(imu.moving, 5.0) == 100
    assert "at rest the acceleration" not in health_of(imu)


# Gravity's direction


def test_a_quaternion_in_the_wrong_order_is_warned_of_and_heals(
    device: Callable[..., Device],
) -> None:
    imu = device()
    assert imu.send(lambda: imu.at_rest(q=[1.0, 0.0, 0.0, 0.0]), 12.0) == 240
    assert "is mapping.orientation.order wxyz, not xyzw?" in health_of(imu)
    imu.send(lambda: imu.at_rest(q=[0.0, 0.0, 0.0, 1.0]), 5.0)
    assert health_of(imu) == ""


def test_an_orientation_that_gravity_contradicts_is_refused_by_option_until_it_fits(
    device: Callable[..., Device],
) -> None:
    imu = device(gravity_direction="reject")
    imu.send(lambda: imu.at_rest(z=-9.81, q=[0.0, 0.0, 0.0, 1.0]), 12.0)
    assert reasons(imu)["implausible_orientation"] > 40
    imu.send(lambda: imu.at_rest(q=[0.0, 0.0, 0.0, 1.0]), 5.0)
    assert imu.send(lambda: imu.at_rest(q=[0.0, 0.0, 0.0, 1.0]), 5.0) == 100


def test_gravitys_direction_can_be_left_alone(device: Callable[..., Device]) -> None:
    imu = device(gravity_direction="off")
    imu.send(lambda: imu.at_rest(q=[1.0, 0.0, 0.0, 0.0]), 12.0)
    assert health_of(imu) == ""


# Frozen


STUCK = {"acc": [0.0213, -0.0544, 9.8012], "gyr": [0.0012, -0.0021, 0.0007]}


def test_a_sensor_that_hangs_is_warned_of_and_heals(device: Callable[..., Device]) -> None:
    imu = device()
    imu.send(imu.at_rest, 3.0)
    assert imu.send(lambda: STUCK, 3.0) == 60
    assert "does the sensor hang?" in health_of(imu)
    imu.send(imu.at_rest, 1.0)
    assert health_of(imu) == ""


def test_a_sensor_that_hangs_is_refused_by_option_until_its_first_other_sample(
    device: Callable[..., Device],
) -> None:
    imu = device(frozen="reject", frozen_after=1.0)
    published = imu.send(lambda: STUCK, 3.0)
    assert published in (21, 22)
    assert reasons(imu) == {"frozen": 60 - published}
    assert imu.send(imu.at_rest, 1.0) == 20


@pytest.mark.parametrize("mode", ["warn", "off"])
def test_rounded_numbers_that_repeat_are_no_fault(device: Callable[..., Device], mode: str) -> None:
    imu = device(frozen=mode)
    rounded = {"acc": [0.1, 0.0, 9.8], "gyr": [0.0, 0.0, 0.0]}
    imu.send(lambda: STUCK if mode == "off" else rounded, 30.0)
    assert health_of(imu) == ""


# The device's clock


def test_a_clock_five_and_a_half_hours_ahead_is_warned_of_as_a_time_zone(
    device: Callable[..., Device],
) -> None:
    imu = device(time_source="device")
    ahead_ns = (5 * 3600 + 1800) * S
    assert imu.send(lambda: imu.dated(ahead_ns, as_text=True), 5.0) == 100
    assert "the device's clock is 5 h 30 min ahead: a time zone?" in health_of(imu)
    imu.send(lambda: imu.dated(0, as_text=True), 3.0)
    assert health_of(imu) == ""
    assert reasons(imu) == {}, "a clock that was wrong and is right is followed at once"


def test_by_option_a_wrong_clock_is_not_believed(device: Callable[..., Device]) -> None:
    imu = device(time_source="device", device_clock="arrival", device_clock_limit=30.0)
    imu.send(lambda: imu.dated(47 * S), 5.0)
    assert "47 s ahead" in health_of(imu)
    assert all(
        abs(message.header.stamp.nanoseconds - imu.now_ns) < S
        for _, message in imu.rig.send(json.dumps(imu.dated(47 * S)).encode(), imu.now_ns)
    )
    counts = imu.rig.reader.counts
    assert counts.time_unusable > 40
    assert set(counts.by_reason) == {"implausible_date"}
    assert imu.send(lambda: imu.dated(-20 * S), 5.0) == 100
    assert health_of(imu) == ""


@pytest.mark.parametrize("absurd_s", [4_294_967_295, 2**31 - 5, 315_964_800, 951_782_400])
def test_one_absurd_date_costs_none_of_the_good_ones_after_it(
    device: Callable[..., Device], absurd_s: int
) -> None:
    imu = device(time_source="device")
    imu.send(lambda: imu.dated(-S // 100), 2.0)
    imu.rig.send(json.dumps(imu.at_rest(at=absurd_s)).encode(), imu.now_ns)
    assert imu.send(lambda: imu.dated(-S // 100), 5.0) == 100
    assert reasons(imu) == {"implausible_date": 1}


def test_a_date_that_is_never_usable_is_said(device: Callable[..., Device]) -> None:
    imu = device(time_source="device")
    assert imu.send(lambda: imu.at_rest(at="12:00:01"), 5.0) == 100
    said = "the device's time is unusable, samples are stamped on arrival: '12:00:01' is no date"
    assert said in health_of(imu)
    imu.send(lambda: imu.dated(0), 1.0)
    assert health_of(imu) == ""


def test_dates_that_are_all_absurd_are_said(device: Callable[..., Device]) -> None:
    imu = device(time_source="device")
    assert imu.send(lambda: imu.at_rest(at=2**32 - 1), 5.0) == 100
    assert "samples are stamped on arrival: dated 2106-02-07 06:28:15 UTC" in health_of(imu)
    assert imu.rig.reader.counts.time_unusable == 100


def test_the_clock_can_be_left_alone(device: Callable[..., Device]) -> None:
    imu = device(time_source="device", device_clock="off")
    imu.send(lambda: imu.dated(3600 * S), 5.0)
    assert health_of(imu) == ""


# Checksums


def signed(data: dict[str, Any], kind: str, separator: str = "*") -> bytes:
    compute, digits = CHECKSUMS[kind]
    content = json.dumps(data).encode()
    return content + f"{separator}{compute(content):0{digits}x}".encode()


@pytest.mark.parametrize("kind", CHECKSUMS)
def test_lines_with_a_checksum_are_read_and_spliced_ones_are_refused(
    device: Callable[..., Device], kind: str
) -> None:
    imu = device(checksum=kind)
    first = signed({"acc": [0, 0, 9.8], "gyr": [0.5, 0, 0]}, kind)
    second = signed({"acc": [0, 3.1, 0], "gyr": [0, 0, 0.25]}, kind)
    assert imu.rig.send(first)
    assert imu.rig.send(second)
    # Valid JSON, with a vector of each.
    spliced = first[: first.index(b'"gyr"')] + second[second.index(b'"gyr"') :]
    assert imu.rig.send(spliced) == []
    assert imu.rig.send(first.partition(b"*")[0]) == []
    assert imu.rig.send(b"MPU6050 Found!") == []
    assert imu.rig.send(first)
    assert reasons(imu) == {"bad_checksum": 1, "no_checksum": 1, "not_data": 1}


def test_without_the_parameter_a_checksum_is_no_part_of_a_line(
    device: Callable[..., Device],
) -> None:
    imu = device()
    assert imu.rig.send(signed({"acc": [0, 0, 9.8], "gyr": [0, 0, 0]}, "xor")) == []
    assert reasons(imu) == {"bad_json": 1}


def test_another_separator_is_a_parameter_and_must_be_one(device: Callable[..., Device]) -> None:
    imu = device(checksum="crc32", checksum_separator="#")
    assert imu.rig.send(signed({"acc": [0, 0, 9.8], "gyr": [0, 0, 0]}, "crc32", "#"))
    with pytest.raises(ParameterError, match="checksum_separator"):
        device(checksum="crc32", checksum_separator="")
    with pytest.raises(ParameterError, match="parameter checksum is one of none, xor"):
        device(checksum="crc8")


# Sentinels


def test_a_stated_number_means_no_reading_and_the_rest_of_the_sample_goes_out(
    device: Callable[..., Device],
) -> None:
    imu = device(**{"mapping.sentinels": [-999.0, 65535.0]})
    good = {"acc": [0.1, 0.0, 9.8], "gyr": [0.0, 0.1, 0.0]}
    for lost in ([-999, -999, -999], [65535, 0.5, 0.5], [0.5, 0.5, -999.0]):
        ((topic, message),) = imu.rig.send({**good, "gyr": lost})
        assert topic == "data_raw"
        assert message.angular_velocity_covariance[0] == -1.0
        assert message.linear_acceleration.z == 9.8
    ((_, message),) = imu.rig.send(good)
    assert message.angular_velocity.y == 0.1
    assert imu.rig.reader.counts.left_out == {}


@pytest.mark.parametrize(
    ("lost", "options"),
    [
        # As raw counts of 16 bits, of a unit, negated, in a text, of a value that no scale has.
        ([-32768, -32768, -32768], {"mapping.linear_acceleration.unit": "mg"}),
        ([65535, 65535, 65535], {"mapping.linear_acceleration.unit": "g"}),
        ([8191.75, 0, 0], {}),
        ([1e9, 1e9, 1e9], {}),
        (["-999", "0.5", "9.8"], {"mapping.numeric_strings": True}),
        ([-999, 0, 0], {"mapping.linear_acceleration.paths": ["-acc[0]", "acc[1]", "acc[2]"]}),
    ],
)
def test_sentinels_are_compared_as_the_payload_has_them(
    device: Callable[..., Device],
    caplog: pytest.LogCaptureFixture,
    lost: list[Any],
    options: dict[str, Any],
) -> None:
    sentinels = [-32768.0, 65535.0, 8191.75, 1e9, -999.0]
    required = {"mapping.required": ["linear_acceleration"]}
    imu = device(**{"mapping.sentinels": sentinels, **required, **options})
    assert imu.rig.send({"acc": lost, "gyr": [0, 0, 0.1]}) == []
    assert reasons(imu) == {"missing_group": 1}
    assert imu.rig.send({"acc": [0.5, 0.5, 0.5], "gyr": [0, 0, 0.1]})
    if not isinstance(lost[0], str):
        said = f"linear_acceleration: {lost[0]} means that there is no reading"
        assert any(said in message for message in caplog.messages)


def test_without_stated_sentinels_a_number_is_a_number(device: Callable[..., Device]) -> None:
    imu = device()
    assert imu.rig.send({"acc": [-999, 0, 0], "gyr": [0, 0, 0]})[0][1].linear_acceleration.x == 0.0
    assert imu.rig.reader.counts.left_out == {"out_of_range": 1}


# What has no effect is said once.


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"device_clock": "arrival"}, "device_clock has no effect: time_source is arrival"),
        ({"device_clock_limit": 1.0}, "device_clock_limit has no effect: time_source is arrival"),
        (
            {"device_clock_limit": 1.0, "device_clock": "off", "time_source": "device"},
            "device_clock_limit has no effect: device_clock is off",
        ),
        ({"frozen_after": 9.0, "frozen": "off"}, "frozen_after has no effect: frozen is off"),
        ({"checksum_separator": "#"}, "checksum_separator has no effect: checksum is none"),
        (
            {"gravity_direction": "reject", "mapping.orientation.paths": []},
            "gravity_direction has no effect: mapping.orientation.paths is empty",
        ),
        (
            {
                "plausibility": "reject",
                "mapping.linear_acceleration.paths": [],
                "mapping.linear_acceleration.unit": "",
                "mapping.required": ["angular_velocity"],
            },
            "plausibility has no effect: mapping.linear_acceleration.paths is empty",
        ),
    ],
)
def test_a_parameter_that_changes_nothing_is_named_once(
    device: Callable[..., Device],
    caplog: pytest.LogCaptureFixture,
    options: dict[str, Any],
    said: str,
) -> None:
    device(**options)
    assert caplog.messages.count(said) == 1


# Together


def test_several_findings_are_said_together_and_each_heals_alone(
    device: Callable[..., Device],
) -> None:
    imu = device()
    imu.send(lambda: imu.at_rest(z=-1.0, q=[0.0, 0.0, 0.0, 1.0]), 12.0)
    assert "are the numbers in g?; at rest gravity is 179 degrees" in health_of(imu)
    imu.send(lambda: imu.at_rest(z=1.0, q=[0.0, 0.0, 0.0, 1.0]), 6.0)
    assert health_of(imu).endswith("are the numbers in g?")


def test_a_good_reader_has_nothing_to_say_with_all_checks_on(
    device: Callable[..., Device],
) -> None:
    everything = {"plausibility": "reject", "gravity_direction": "reject", "frozen": "reject"}
    imu = device(time_source="device", device_clock="arrival", **everything)
    sent = imu.send(lambda: {**imu.dated(-S // 50), "q": [0.0, 0.0, 0.38268343, 0.92387953]}, 60.0)
    assert sent == 1200
    assert imu.rig.reader.health.message == "samples arrive"
    assert reasons(imu) == {}


def test_the_date_of_the_samples_of_the_tests_is_theirs() -> None:
    stamp = payload(linear_acceleration=vector(z=1.0))["header"]["stamp"]
    assert stamp["sec"] * S + stamp["nanosec"] == GOOD_DATE_NS
