import json
import math
import re
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from rosbase.errors import MappingError
from rosbase.imu.mapping import ImuMapping, Sample, SampleReader
from rosbase.imu.presets import PRESETS
from rosbase.imu.rejects import REASONS
from rosbase.imu.units import STANDARD_GRAVITY
from rosbase.mapping import quick_reading
from rosbase.mapping.rejects import Reject
from support.samples import FAULTS, GOOD, GOOD_FRAME, ORIENTATION_FAULTS, frame, vector
from support.strategies import frames, good_payloads, json_values, payloads


def mapping(preset: str = "ros", **changes: Any) -> ImuMapping:
    (values,) = [p.values for p in PRESETS if p.name == preset]
    fields: dict[str, Any] = {key.replace(".", "_"): value for key, value in values.items()}
    fields |= changes
    for key, value in fields.items():
        fields[key] = tuple(value) if isinstance(value, list) else value
    return ImuMapping(**fields)


DEFAULT = mapping().compile(device_time=True)


def read(reader: SampleReader, payload: Any) -> Sample:
    sample = reader(json.dumps(payload).encode())
    assert isinstance(sample, Sample), sample
    return sample


def reason(reader: SampleReader, payload: Any) -> str:
    reject = reader(payload if isinstance(payload, bytes) else json.dumps(payload).encode())
    assert isinstance(reject, Reject), reject
    return reject.reason


def test_the_default_schema_reads_a_ros_shaped_sample() -> None:
    assert DEFAULT(GOOD_FRAME) == Sample(
        orientation=(0.0, 0.0, 0.0, 1.0),
        angular_velocity=(0.1, -0.2, 0.3),
        linear_acceleration=(0.0, 0.0, 9.80665),
        magnetic_field=None,
        device_time_ns=1_700_000_000_000_000_005,
    )


TOLERANT = mapping(quaternion_tolerance=0.5).compile(device_time=True)


@given(frames, st.sampled_from([DEFAULT, TOLERANT]))
def test_no_input_makes_it_raise_and_nothing_unfit_comes_out(
    data: bytes, reader: SampleReader
) -> None:
    sample = reader(data)
    event(sample.reason if isinstance(sample, Reject) else "sample")
    if isinstance(sample, Reject):
        assert sample.reason in REASONS
    else:
        assert isinstance(sample, Sample)
        check_fit(sample)


@given(good_payloads())
def test_every_good_payload_becomes_a_fit_sample(payload: Any) -> None:
    sample = read(DEFAULT, payload)
    check_fit(sample)
    assert (sample.orientation is None) is not bool(payload.get("orientation"))
    assert sample.angular_velocity == tuple(payload["angular_velocity"].values())
    assert sample.linear_acceleration == tuple(payload["linear_acceleration"].values())


def check_fit(sample: Sample) -> None:
    assert sample.angular_velocity is not None
    assert sample.linear_acceleration is not None
    for group, size in zip(sample[:4], (4, 3, 3, 3), strict=True):
        if group is not None:
            assert len(group) == size
            assert all(type(number) is float and math.isfinite(number) for number in group)
    if sample.orientation is not None:
        assert math.hypot(*sample.orientation) == pytest.approx(1.0, abs=2e-6)


def careful() -> SampleReader:
    """A reader without the fast way."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(quick_reading, "shared_parent", lambda paths: None)
        return mapping().compile(device_time=True)


CAREFUL = careful()


@given(payloads | good_payloads())
def test_the_fast_way_and_the_careful_way_agree(payload: Any) -> None:
    data = json.dumps(payload).encode()
    assert DEFAULT(data) == CAREFUL(data)


@given(json_values, st.lists(st.sampled_from(["a", "b", "0", "1", "[2]"]), min_size=1))
def test_no_payload_makes_any_path_raise(payload: Any, steps: list[str]) -> None:
    path = ".".join(steps).replace(".[", "[")
    reader = ImuMapping(linear_acceleration_paths=(path,), linear_acceleration_unit="g").compile()
    sample = reader(json.dumps({"a": payload, "b": [payload]}).encode())
    assert isinstance(sample, (Sample, Reject))


@pytest.mark.parametrize("fault", FAULTS)
def test_every_payload_fault_has_its_reason(fault: str) -> None:
    line, expected = FAULTS[fault]
    assert reason(DEFAULT, line) == expected
    assert expected in REASONS


@pytest.mark.parametrize("fault", ORIENTATION_FAULTS)
def test_a_quantity_that_is_not_required_is_left_out_with_its_reason(fault: str) -> None:
    line, expected = ORIENTATION_FAULTS[fault]
    sample = DEFAULT(line)
    assert isinstance(sample, Sample)
    assert sample.orientation is None
    assert sample.linear_acceleration == (0.0, 0.0, 9.80665)
    assert [reject.reason for reject in sample.left_out] == [expected]
    assert sample.left_out[0].detail.startswith("orientation")
    needed = mapping(required=("orientation",)).compile()
    assert reason(needed, line) == expected


def test_integers_are_numbers() -> None:
    sample = read(DEFAULT, {**GOOD, "linear_acceleration": vector(0, 0, 10)})
    assert sample.linear_acceleration == (0.0, 0.0, 10.0)
    assert all(type(number) is float for number in sample.linear_acceleration)


def test_absent_optional_groups_are_absent_in_the_sample() -> None:
    absent: list[Any] = [{}, None, [], "none"]
    for orientation in absent:
        assert read(DEFAULT, {**GOOD, "orientation": orientation}).orientation is None
    without_header = {key: value for key, value in GOOD.items() if key != "header"}
    assert read(DEFAULT, without_header).device_time_ns is None


def test_a_number_too_large_for_its_si_unit_is_refused() -> None:
    milli = mapping(linear_acceleration_unit="g").compile()
    assert reason(milli, {**GOOD, "linear_acceleration": vector(z=1e308)}) == "non_finite"
    for absurd in (1e308, -1e200, 2e9, 314.0):
        assert reason(DEFAULT, {**GOOD, "linear_acceleration": vector(absurd)}) == "out_of_range"
    assert read(DEFAULT, {**GOOD, "linear_acceleration": vector(313.0)})


def test_numeric_strings_only_if_allowed_and_only_json_numbers() -> None:
    lenient = mapping(numeric_strings=True).compile()
    assert read(lenient, {**GOOD, "angular_velocity": vector("1.5", "-2", "3e-1")}) == Sample(
        (0.0, 0.0, 0.0, 1.0), (1.5, -2.0, 0.3), (0.0, 0.0, 9.80665), None, None
    )
    for text in ("nan", "inf", "1_0", "٣", "0x1", "", "1,5"):
        assert reason(lenient, {**GOOD, "angular_velocity": vector(text)}) == "wrong_type"
    assert reason(lenient, {**GOOD, "angular_velocity": vector("1e999")}) == "non_finite"


def test_nearly_unit_quaternions_are_normalised_and_unit_ones_left_alone() -> None:
    rough = read(DEFAULT, {**GOOD, "orientation": {**vector(z=0.71), "w": 0.71}})
    assert rough.orientation == pytest.approx((0.0, 0.0, 0.70710678, 0.70710678))
    exact = {"x": 0.0, "y": 0.6, "z": 0.0, "w": 0.8000001}
    assert read(DEFAULT, {**GOOD, "orientation": exact}).orientation == (0.0, 0.6, 0.0, 0.8000001)


def test_the_order_of_a_quaternion_list_is_stated() -> None:
    reader = mapping(orientation_paths=("q",), orientation_order="wxyz").compile()
    sample = read(reader, {**GOOD, "q": [0.8, 0.6, 0.0, 0.0]})
    assert sample.orientation == (0.6, 0.0, 0.0, 0.8)


def test_lists_dotted_paths_and_alternatives() -> None:
    reader = ImuMapping(
        linear_acceleration_paths=("data[0].acc",),
        linear_acceleration_unit="g",
        angular_velocity_paths=("gyro.0|g.x", "gyro.1|g.y", "gyro.2|g.z"),
        angular_velocity_unit="deg/s",
    ).compile()
    sample = read(reader, {"data": [{"acc": [0, 1, 0]}], "g": vector(90, 0, 0)})
    assert sample.linear_acceleration == (0.0, STANDARD_GRAVITY, 0.0)
    assert sample.angular_velocity == pytest.approx((1.5708, 0.0, 0.0), abs=1e-4)
    assert reason(reader, {"data": [{"acc": [0, 1]}]}) == "incomplete"


def test_a_list_of_another_length_is_not_the_vector() -> None:
    reader = ImuMapping(linear_acceleration_paths=("a|b",), linear_acceleration_unit="g").compile()
    for numbers in ([0, 0, 1, 5], [0.0, 0.0, 1.0, 5.0], [0.0] * 6):
        assert reason(reader, {"a": numbers}) == "wrong_type"
        assert reason(reader, {"b": numbers}) == "wrong_type"
    assert read(reader, {"a": [0.0, 0.0, 1.0]}).linear_acceleration == (0.0, 0.0, 9.80665)


def test_alternatives_belong_together() -> None:
    reader = mapping(
        linear_acceleration_paths=("new.x|old.x", "new.y|old.y", "new.z|old.z"),
        linear_acceleration_unit="m/s^2",
    ).compile()
    old = {"old": vector(7.0, 8.0, 9.0)}
    assert read(reader, {**GOOD, **old}).linear_acceleration == (7.0, 8.0, 9.0)
    both = {**GOOD, **old, "new": vector(1.0, 2.0, 3.0)}
    assert read(reader, both).linear_acceleration == (1.0, 2.0, 3.0)
    assert reason(reader, {**GOOD, **old, "new": {"x": 1.0, "y": 2.0}}) == "incomplete"


def test_a_step_with_leading_zeros_is_a_key() -> None:
    reader = ImuMapping(
        linear_acceleration_paths=("007", "008", "009"), linear_acceleration_unit="m/s^2"
    ).compile()
    payload = {"007": 1, "008": 2, "009": 3, "7": 4, "8": 5, "9": 6}
    assert read(reader, payload).linear_acceleration == (1.0, 2.0, 3.0)


def test_a_byte_order_mark_does_not_hide_a_sample() -> None:
    assert isinstance(DEFAULT(b"\xef\xbb\xbf" + GOOD_FRAME), Sample)


def test_the_nul_that_ends_a_text_in_c_does_not_hide_a_sample() -> None:
    assert DEFAULT(GOOD_FRAME + b"\0") == DEFAULT(GOOD_FRAME)
    assert DEFAULT(b"\xef\xbb\xbf" + GOOD_FRAME + b"\0\0") == DEFAULT(GOOD_FRAME)
    assert DEFAULT(b"\0") == Reject("not_data")


def test_a_digit_may_also_be_a_key() -> None:
    reader = ImuMapping(linear_acceleration_paths=("a",), linear_acceleration_unit="g").compile()
    assert read(reader, {"a": {"0": 0, "1": 0, "2": 1}}).linear_acceleration == (0, 0, 9.80665)


@pytest.mark.parametrize(
    ("condition", "payload", "passes"),
    [
        ("T=1002", {"T": 1002}, True),
        ("T=1002", {"T": 1001}, False),
        ("T=1002", {"T": "1002"}, False),
        ("T=1002", {}, False),
        ("T=1", {"T": True}, False),
        ("kind=imu", {"kind": "imu"}, True),
        ("T=1,2", {"T": 1}, False),
        ("T=1,2", {"T": "1,2"}, True),
        ('kind="imu"', {"kind": "imu"}, True),
        ("meta.ok=true", {"meta": {"ok": True}}, True),
        ("meta.ok=true", {"meta": {"ok": 1}}, False),
    ],
)
def test_select_lets_only_its_own_kind_through(
    condition: str, payload: dict[str, Any], passes: bool
) -> None:
    reader = mapping(select=(condition,)).compile()
    if passes:
        read(reader, {**GOOD, **payload})
    else:
        assert reason(reader, {**GOOD, **payload}) == "not_selected"


WAVESHARE = {
    "T": 1002,
    **{"r": 0.1, "p": 0.2, "ax": 0.0, "ay": 0.0, "az": 9.8, "gx": 0.1, "gy": 0.2, "gz": 0.3},
    **{"mx": 20.0, "my": -5.0, "mz": 40.0, "temp": 30.1},
}


def test_waveshare_ugv_lines() -> None:
    reader = mapping("waveshare_ugv").compile()
    sample = read(reader, WAVESHARE)
    assert sample.orientation is None
    assert sample.linear_acceleration == (0.0, 0.0, 9.8)
    assert sample.angular_velocity == (0.1, 0.2, 0.3)
    assert sample.magnetic_field == pytest.approx((20e-6, -5e-6, 40e-6))
    assert reason(reader, {"T": 1001, "L": 0, "R": 0}) == "not_selected"
    assert reason(reader, {"T": 1002, "temp": 30.1}) == "no_imu_data"


def test_mpu6050_lines() -> None:
    reader = mapping("mpu6050").compile()
    line = b'{"accel_x":0.1,"accel_y":0,"accel_z":9.8,"gyro_x":0,"gyro_y":0,"gyro_z":0.5}'
    sample = reader(line)
    assert isinstance(sample, Sample)
    assert sample.linear_acceleration == (0.1, 0.0, 9.8)
    assert sample.angular_velocity == (0.0, 0.0, 0.5)
    assert reason(reader, b"MPU6050 Found!") == "not_data"


@pytest.mark.parametrize(
    ("stamp", "paths", "unit", "expected"),
    [
        (1_700_000_000.5, ["t"], "s", 1_700_000_000_500_000_000),
        (1_700_000_000_123, ["t"], "ms", 1_700_000_000_123_000_000),
        ("2025-10-01T12:00:00Z", ["t"], "s", 1_759_320_000_000_000_000),
        ("2025-10-01T14:00:00+02:00", ["t"], "s", 1_759_320_000_000_000_000),
        ("2025-10-01T12:00:00", ["t"], "s", None),
        ("N/A", ["t"], "s", None),
        (123_456, ["t"], "ms", None),
        (2**32 - 1, ["t"], "us", None),
        (True, ["t"], "s", None),
        (None, ["t"], "s", None),
        (float("nan"), ["t"], "s", None),
        (1e300, ["t"], "s", None),
        (10**400, ["t"], "s", None),
        ({"secs": 1_700_000_000, "nsecs": 7}, ["t.secs", "t.nsecs"], "", 1_700_000_000_000_000_007),
        ({"secs": 1_700_000_000, "nsecs": -5}, ["t.secs", "t.nsecs"], "", None),
        ({"secs": 1_700_000_000, "nsecs": 10**9}, ["t.secs", "t.nsecs"], "", None),
        ({"secs": 12, "nsecs": 7}, ["t.secs", "t.nsecs"], "", None),
        ({"secs": 1_700_000_000}, ["t.secs", "t.nsecs"], "", None),
    ],
)
def test_only_a_date_is_a_device_time(
    stamp: Any, paths: list[str], unit: str, expected: int | None
) -> None:
    reader = mapping(time_paths=tuple(paths), time_unit=unit).compile(device_time=True)
    assert read(reader, {**GOOD, "t": stamp}).device_time_ns == expected


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({}, "names no quantity"),
        ({"quaternion_tolerance": 1.0}, "quaternion_tolerance is from 0 to 0.5"),
        ({"linear_acceleration_paths": ("a",)}, "linear_acceleration.unit must be stated: m/s^2"),
        (
            {"linear_acceleration_paths": ("a",), "linear_acceleration_unit": "G"},
            "linear_acceleration.unit is one of m/s^2, g, mg, not 'G'",
        ),
        ({"orientation_paths": ("a", "b")}, "orientation.paths takes 4 paths or one, not 2"),
        ({"orientation_paths": ("q",), "orientation_order": "zyx"}, "is xyzw or wxyz, not 'zyx'"),
        ({"orientation_paths": ("a..b",)}, "'a..b' is not a path"),
        ({"orientation_paths": ("",)}, "'' is not a path"),
        ({"orientation_paths": ("a|b", "c", "d", "e")}, "the same number of alternatives"),
        ({"orientation_paths": ("q",), "required": ("gps",)}, "not 'gps'"),
        ({"orientation_paths": ("q",), "required": ("magnetic_field",)}, "paths is empty"),
        (
            {"orientation_paths": ("q",), "select": ("T",), "time_paths": ("s", "ns")},
            "'T' is not a condition such as T=1002",
        ),
        ({"orientation_paths": ("q",)}, "mapping.time.paths is empty"),
        ({"orientation_paths": ("q",), "time_paths": ("t",)}, "time.unit is one of s, ms, us, ns"),
    ],
)
def test_a_mapping_that_cannot_be_is_one_line(fields: dict[str, Any], complaint: str) -> None:
    with pytest.raises(MappingError, match=re.escape(complaint)) as caught:
        ImuMapping(**fields).compile(device_time=True)
    assert "\n" not in str(caught.value)


def test_multi_line_json_says_what_to_do() -> None:
    assert "one line" in REASONS["multi_line"]


def test_frames_with_extra_keys_pass() -> None:
    assert isinstance(DEFAULT(frame(temperature=21.5, name="x", list=[{}])), Sample)
