"""Payloads met in the field that once made a wrong number, or cost a good one: A, B, D, E and F.

The letters are the kinds: a position stands in for a name (A), a number is believed against all
that is known (B), a message holds more than is taken (D), a bad part costs the good ones (E),
something is asked for and not done (F).
"""

import json
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rosbase.cli.monitor import message_to_json
from rosbase.errors import MappingError
from rosbase.imu.health import HealthLevel
from rosbase.messages import Time
from support.reader_rig import Rig

Rigs = Callable[..., Rig]


@pytest.fixture
def rigs() -> Iterator[Rigs]:
    made: list[Rig] = []

    def make(**parameters: Any) -> Rig:
        made.append(Rig(**{"preset": "custom", **parameters}))
        return made[-1].activate()

    yield make
    for rig in made:
        rig.backend.close()


def at(
    acc: str | list[str] = "", gyr: str | list[str] = "", mag: str | list[str] = "", **more: Any
) -> dict[str, Any]:
    """Parameters for paths in SI units (uT for the field); the names of others with `__`."""
    found: dict[str, Any] = {name.replace("__", "."): value for name, value in more.items()}
    for quantity, paths, unit in (
        ("linear_acceleration", acc, "m/s^2"),
        ("angular_velocity", gyr, "rad/s"),
        ("magnetic_field", mag, "uT"),
    ):
        if paths:
            found[f"mapping.{quantity}.paths"] = [paths] if isinstance(paths, str) else paths
            found[f"mapping.{quantity}.unit"] = unit
    return found


BOTH = ["linear_acceleration", "angular_velocity"]


def acc_of(published: list[tuple[str, Any]]) -> list[tuple[float, float, float]]:
    vectors = [message.linear_acceleration for topic, message in published if topic != "mag"]
    return [(v.x, v.y, v.z) for v in vectors]


def gyr_of(published: list[tuple[str, Any]]) -> list[tuple[float, float, float]]:
    vectors = [message.angular_velocity for topic, message in published if topic != "mag"]
    return [(v.x, v.y, v.z) for v in vectors]


# A. A position, or a key that others share, stands in for a name.

ACC = {"id": "acc", "v": [0.0, 0.1, 9.7]}
GYR = {"id": "gyr", "v": [0.1, 0.0, 0.2]}


def test_a_an_index_into_a_list_of_sensors_is_refused_in_either_order(rigs: Rigs) -> None:
    rig = rigs(**at("sensors[0].v"))
    for sensors in ([ACC, GYR], [GYR, ACC]):
        assert rig.send({"sensors": sensors}) == []
    assert rig.reader.counts.by_reason == {"surplus": 2}
    assert acc_of(rig.send({"sensors": [ACC]})) == [(0.0, 0.1, 9.7)]


def test_a_a_condition_finds_the_sensor_in_either_order(rigs: Rigs) -> None:
    rig = rigs(**at("sensors[id=acc].v", "sensors[id=gyr].v"))
    for sensors in ([ACC, GYR], [GYR, ACC], [{"id": "baro", "v": [1013.0]}, GYR, 5, ACC]):
        published = rig.send({"sensors": sensors})
        assert acc_of(published) == [(0.0, 0.1, 9.7)]
        assert gyr_of(published) == [(0.1, 0.0, 0.2)]
    ((_, message),) = rig.send({"sensors": [GYR]})
    assert message.linear_acceleration_covariance[0] == -1.0


def test_a_two_quantities_with_the_same_paths_are_refused_at_the_start(rigs: Rigs) -> None:
    with pytest.raises(MappingError, match="tell them apart by a condition"):
        rigs(**at("xyz", mag="xyz"))


def test_a_a_condition_tells_messages_with_the_same_keys_apart(rigs: Rigs) -> None:
    rig = rigs(**at("[kind=acc].xyz", mag="[kind=mag].xyz"))
    ((topic, message),) = rig.send({"kind": "mag", "xyz": [21.0, -4.0, 43.5]})
    assert (topic, message.magnetic_field.x) == ("mag", pytest.approx(21e-6))
    assert acc_of(rig.send({"kind": "acc", "xyz": [0.02, 0.05, 9.79]})) == [(0.02, 0.05, 9.79)]
    assert rig.send({"kind": "light", "xyz": [1, 2, 3]}) == []


def test_a_a_phone_that_sends_its_sensors_in_changing_order(rigs: Rigs) -> None:
    def path(name: str) -> list[str]:
        return [f"payload[name={name}].values.{axis}" for axis in "xyz"]

    rig = rigs(**at(path("accelerometer"), path("gyroscope"), path("magnetometer")))

    def entry(name: str, *numbers: float) -> dict[str, Any]:
        return {"name": name, "values": dict(zip("xyz", numbers, strict=True))}

    gyr, acc = entry("gyroscope", 0.1, 0, 0.2), entry("accelerometer", 0, 0.1, 9.7)
    gravity = entry("gravity", 0, 0, 9.81)
    for order in ([gyr, acc, gravity], [gravity, acc, gyr], [acc, gravity, gyr]):
        published = rig.send({"messageId": 1, "payload": order})
        assert acc_of(published) == [(0.0, 0.1, 9.7)]
        assert gyr_of(published) == [(0.1, 0.0, 0.2)]
    # Two readings of one sensor: which is it?
    assert rig.send({"payload": [acc, gyr, entry("accelerometer", 0, 0, 9.8)]})
    assert rig.reader.counts.left_out == {"surplus": 1}


def test_a_android_sensor_numbers_and_pairs_of_name_and_value(rigs: Rigs) -> None:
    android = rigs(**at("[type=1].values", "[type=4].values"))
    assert acc_of(android.send({"type": 1, "values": [0.1, 0.2, 9.8]})) == [(0.1, 0.2, 9.8)]
    assert gyr_of(android.send({"type": 4, "values": [0.1, 0.2, 0.3]})) == [(0.1, 0.2, 0.3)]
    assert android.send({"type": True, "values": [0.1, 0.2, 9.8]}) == []
    assert android.send({"type": "1", "values": [0.1, 0.2, 9.8]}) == []
    pairs = rigs(**at("[0=A][1]", "[0=G][1]"))
    assert acc_of(pairs.send(b'[["G",[0.1,0.2,0.3]],["A",[0.1,0.2,9.8]]]')) == [(0.1, 0.2, 9.8)]


def test_a_positions_may_be_named_in_a_condition(rigs: Rigs) -> None:
    select = ["sensors[0].id=acc", "sensors[1].id=gyr"]
    rig = rigs(**at("sensors[0].v", mapping__select=select))
    assert acc_of(rig.send({"sensors": [ACC, GYR]})) == [(0.0, 0.1, 9.7)]
    assert rig.send({"sensors": [GYR, ACC]}) == []
    assert rig.reader.counts.by_reason == {"not_selected": 1}


# B. A number is believed although what is known contradicts it.


def test_b_numbers_beyond_the_full_scale_are_refused(rigs: Rigs) -> None:
    rig = rigs(**at("acc", "gyr", mapping__required=BOTH))
    assert rig.send({"acc": [0.1, 0.0, 9.8], "gyr": [0.01, 0.0, 0.18]})
    assert rig.send({"acc": [0.1, 0.0, 9.8], "gyr": [0.01, 0.0, 1800]}) == []
    assert rig.send({"acc": [0.1, 0.0, 4000.0], "gyr": [0.01, 0.0, 0.18]}) == []
    # 32,767 counts of a register that nobody has scaled, and a value of a burst bus.
    assert rig.send({"acc": [0.1, 0.0, 9.8], "gyr": [0.01, 0.0, 32767]}) == []
    assert rig.send({"acc": [-327.68, 0.0, 9.8], "gyr": [0.01, 0.0, 0.18]}) == []
    assert rig.reader.counts.by_reason == {"out_of_range": 4}


def test_b_the_full_scale_is_a_parameter_of_each_component(rigs: Rigs) -> None:
    high_g = rigs(**at("acc", linear_acceleration_full_scale=2000.0))
    assert high_g.send({"acc": [1500.0, 1500.0, 1500.0]})
    assert high_g.send({"acc": [0.0, 0.0, -2001.0]}) == []
    gyro = rigs(**at(gyr="gyr", angular_velocity_full_scale=4.36))
    assert gyro.send({"gyr": [4.3, 4.3, 4.3]})
    assert gyro.send({"gyr": [4.4, 0, 0]}) == []


def test_b_a_magnetic_field_in_gauss_that_is_said_to_be_tesla_is_left_out(rigs: Rigs) -> None:
    rig = rigs(**{**at("acc", mag="mag"), "mapping.magnetic_field.unit": "T"})
    ((topic, _),) = rig.send({"acc": [0, 0, 9.8], "mag": [0.21, -0.04, 0.43]})
    assert topic == "data_raw"
    assert rig.reader.counts.left_out == {"out_of_range": 1}


@pytest.mark.parametrize(
    "line",
    [
        b'{"acc":[0,0,9.8],"gyr":[0,0,0.5],"acc":[0,0,3.1]}',
        b'{"acc":[0,0,9.8],"gyr":[0,0,0.5],"meta":{"seq":1,"seq":2}}',
        b'{"acc":[0,0,9.8],"gyr":[0,0,0.5],"meta":[{"a":{}},{"b":1,"b":1}]}',
        b'{"acc" : [0,0,9.8], "gyr" : [0,0,0.5], "\\u0061cc" : [0,0,3.1]}',
        # Two lines that a lost line end has spliced.
        b'{"acc":[0,0,9.8],"gyr":[0,0,0.5],"t":1,"acc":[0,0,9.7],"gyr":[0,0,0.4],"t":2}',
    ],
)
def test_b_a_key_twice_is_bad_json(rigs: Rigs, line: bytes) -> None:
    rig = rigs(**at("acc", "gyr"))
    assert rig.send(line) == []
    assert rig.reader.counts.by_reason == {"bad_json": 1}


def test_b_what_the_reader_prints_is_read_again_without_inventing_anything(rigs: Rigs) -> None:
    source = rigs(**at("acc", "gyr"))
    again = rigs(preset="ros", **{"mapping.required": []})
    payloads: list[dict[str, Any]] = [
        {"acc": [0.1, 0, 9.8], "gyr": [0.1, 0, 0.2]},
        {"acc": [0.1, 0, 9.8]},
        {"gyr": [0.1, 0, 0.2]},
    ]
    for payload in payloads:
        ((topic, message),) = source.send(payload)
        ((topic_again, message_again),) = again.send(message_to_json(message).encode())
        assert topic_again == topic == "data_raw"
        assert message_again.orientation_covariance[0] == -1.0
        for name in ("linear_acceleration", "angular_velocity"):
            assert getattr(message_again, name) == getattr(message, name)
            covariance = f"{name}_covariance"
            assert getattr(message_again, covariance) == getattr(message, covariance)
    strict = rigs(preset="ros")
    assert strict.send(message_to_json(message).encode()) == []
    assert strict.reader.counts.by_reason == {"missing_group": 1}


@pytest.mark.parametrize(
    ("covariance", "is_there"),
    [
        ([-1, 0, 0, 0, 0, 0, 0, 0, 0], False),
        ([-1.0, 0, 0], False),
        ([0.0] * 9, True),
        ([0.01], True),
        ([], True),
        (None, True),
        ("-1", True),
        ({"0": -1}, False),
    ],
)
def test_b_a_covariance_of_minus_one_means_that_there_is_no_orientation(
    rigs: Rigs, covariance: Any, is_there: bool
) -> None:
    payload = {
        "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
        "orientation_covariance": covariance,
        "angular_velocity": {"x": 0.0, "y": 0.0, "z": 0.1},
        "linear_acceleration": {"x": 0.0, "y": 0.0, "z": 9.8},
    }
    ((topic, _),) = rigs(preset="ros").send(payload)
    assert topic == ("data" if is_there else "data_raw")


def test_b_a_covariance_of_minus_one_may_be_a_text_if_numbers_are(rigs: Rigs) -> None:
    payload = {
        "orientation": {"x": "0", "y": "0", "z": "0", "w": "1"},
        "orientation_covariance": ["-1", "0", "0"],
        "angular_velocity": {"x": "0.0", "y": "0.0", "z": "0.1"},
        "linear_acceleration": {"x": "0.0", "y": "0.0", "z": "9.8"},
    }
    rig = rigs(preset="ros", **{"mapping.numeric_strings": True})
    ((topic, message),) = rig.send(payload)
    assert topic == "data_raw"
    assert message.orientation_covariance[0] == -1.0
    ((topic, _),) = rig.send({**payload, "orientation_covariance": ["0.01", "0", "0"]})
    assert topic == "data"


# D. A message holds more samples than are taken.

FOUR = {"hz": 200, "acc": [[0.1, 0, 9.8], [0.2, 0, 9.8], [0.3, 0, 9.8], [0.4, 0, 9.8]]}
FRAMES = {"frames": [{"a": {"x": 0, "y": 0, "z": 9.8}}, {"a": {"x": 0.5, "y": 0, "z": 9.8}}]}
MS = 1_000_000


def test_d_an_index_into_a_list_of_samples_is_refused_and_counted(rigs: Rigs) -> None:
    rig = rigs(**at("acc[0]"))
    assert rig.send(FOUR) == []
    assert rig.send({"acc": [[0.1, 0, 9.8]]})
    frames = rigs(**at([f"frames[0].a.{axis}" for axis in "xyz"]))
    assert frames.send(FRAMES) == []
    for found in (rig, frames):
        assert found.reader.counts.by_reason == {"surplus": 1}


def test_d_every_element_becomes_a_sample_with_a_stamp_of_its_own(rigs: Rigs) -> None:
    rig = rigs(**at("acc[*]"))
    rig.send(FOUR, 1_000 * MS)
    published = rig.send(FOUR, 1_020 * MS)
    assert [x for x, _, _ in acc_of(published)] == [0.1, 0.2, 0.3, 0.4]
    stamps = [message.header.stamp.nanoseconds // MS for _, message in published]
    assert stamps == [1_005, 1_010, 1_015, 1_020]
    assert rig.reader.counts.published == 8
    frames = rigs(**at([f"frames[*].a.{axis}" for axis in "xyz"]))
    assert [x for x, _, _ in acc_of(frames.send(FRAMES))] == [0.0, 0.5]


def test_d_a_rate_in_the_payload_tells_how_far_apart_the_samples_are(rigs: Rigs) -> None:
    rig = rigs(**at("acc[*]", mapping__time__interval="hz Hz"))
    stamps = [m.header.stamp.nanoseconds // MS for _, m in rig.send(FOUR, 1_000 * MS)]
    assert stamps == [985, 990, 995, 1_000]


def test_d_dates_of_the_device_for_each_sample_or_a_start_and_an_interval(rigs: Rigs) -> None:
    each = rigs(
        **at(
            [f"data[*].acc_{axis}" for axis in "xyz"],
            time_source="device",
            mapping__time__paths=["data[*].timestamp"],
            mapping__time__unit="s",
        )
    )
    payload = {
        "data": [
            {"timestamp": 1570338716.75, "acc_x": -0.2, "acc_y": -2.9, "acc_z": 9.1, "id": "s"},
            # Such a fleet also sends elements in which only some numbers have changed.
            {"timestamp": 1570338716.76, "acc_x": -0.2, "id": "s"},
            {"timestamp": 1570338716.78, "acc_x": -0.1, "acc_y": -2.9, "acc_z": 9.1, "id": "s"},
        ]
    }
    published = each.send(payload)
    assert [x for x, _, _ in acc_of(published)] == [-0.2, -0.1]
    assert [m.header.stamp.nanosec // MS for _, m in published] == [750, 780]
    assert each.reader.counts.by_reason == {"incomplete": 1}
    start = rigs(
        **at(
            ["x[*]", "y[*]", "z[*]"],
            time_source="device",
            mapping__time__paths=["start"],
            mapping__time__unit="ms",
            mapping__time__interval="5 ms",
        )
    )
    columns = {"start": 1_700_000_000_000, "x": [0.1, 0.2], "y": [0, 0], "z": [9.8, 9.8]}
    stamps = [message.header.stamp for _, message in start.send(columns)]
    assert stamps == [Time(1_700_000_000, 0), Time(1_700_000_000, 5 * MS)]


def test_d_lists_of_different_length_are_a_counted_error(rigs: Rigs) -> None:
    rig = rigs(**at("acc[*]", "gyr[*]", "mag[*]", mapping__required=BOTH))
    acc, gyr = [[0.1, 0, 9.8]] * 3, [[0, 0, 0.1]] * 3
    assert rig.send({"acc": acc, "gyr": gyr[:2]}) == []
    assert rig.reader.counts.by_reason == {"uneven": 1}
    # A slower sensor that is not required is left out of each sample.
    published = rig.send({"acc": acc, "gyr": gyr, "mag": [[21, -4, 43]]})
    assert [topic for topic, _ in published] == ["data_raw"] * 3
    assert rig.reader.counts.left_out == {"uneven": 3}
    columns = rigs(**at(["x[*]", "y[*]", "z[*]"]))
    assert columns.send({"x": [1, 2, 3], "y": [1, 2, 3], "z": [1, 2]}) == []
    assert columns.reader.counts.by_reason == {"uneven": 1}


@pytest.mark.parametrize(
    ("paths", "payload", "reason"),
    [
        # Numbers side by side, twice.
        (["v[0]", "v[1]", "v[2]"], {"v": [0, 0, 9.8, 0, 0, 9.7]}, "surplus"),
        (["v"], {"v": [0, 0, 9.8, 0, 0, 9.7]}, "wrong_type"),
        (["[0].value"], [{"value": [0, 0, 9.8]}, {"value": [0, 0, 9.7]}], "surplus"),
        (["a[0].b[0]"], {"a": [{"b": [[0, 0, 9.8]]}, {"b": [[0, 0, 9.7]]}]}, "surplus"),
        (["readings[1].accel"], {"readings": [{"accel": [0, 0, 9.8]}] * 2}, "surplus"),
        (["a[*]"], {"a": []}, "no_imu_data"),
        (["a[*]"], {"a": {"0": [0, 0, 9.8]}}, "no_imu_data"),
    ],
)
def test_d_more_of_the_same_than_is_read_is_never_silent(
    rigs: Rigs, paths: list[str], payload: Any, reason: str
) -> None:
    rig = rigs(**at(paths))
    assert rig.send(json.dumps(payload).encode()) == []
    assert rig.reader.counts.by_reason == {reason: 1}


def test_d_numbers_side_by_side_with_something_else_behind_them(rigs: Rigs) -> None:
    rig = rigs(**at(["v[0]", "v[1]", "v[2]"], ["v[3]", "v[4]", "v[5]"]))
    published = rig.send({"v": [0.1, 0, 9.8, 0.1, 0, 0.2, 21.5]})
    assert acc_of(published) == [(0.1, 0.0, 9.8)]
    assert gyr_of(published) == [(0.1, 0.0, 0.2)]
    assert rig.send({"v": [0.1, 0, 9.8, 0.1, 0, 0.2] * 2}) == []
    # An element that has nothing at the path is not another sample.
    other = rigs(**at("a[0].v"))
    assert other.send({"a": [{"v": [0, 0, 9.8]}, {"v": None}, {"t": 5}, 7]})


def test_d_readings_of_glasses_with_every_quantity(rigs: Rigs) -> None:
    more = {"mapping.orientation.paths": ["readings[*].quat"], "mapping.orientation.order": "wxyz"}
    rig = rigs(**at("readings[*].accel", "readings[*].gyro", "readings[*].mag"), **more)
    reading = {"accel": [0, 0, 9.8], "gyro": [0, 0, 0.1], "mag": [21, -4, 43], "quat": [1, 0, 0, 0]}
    published = rig.send({"type": "imu_stream_response", "readings": [reading] * 3})
    assert [topic for topic, _ in published].count("data") == 3
    assert [topic for topic, _ in published].count("mag") == 3


# E. One absent or bad part costs the good ones.


@pytest.mark.parametrize(
    ("part", "left_out"),
    [
        ({"mag": [None, None, None]}, {}),
        ({"mag": {"x": None}}, {}),
        ({"mag": None, "q": {"x": None, "y": None, "z": None, "w": None}}, {}),
        ({"q": {"w": 1}}, {"incomplete": 1}),
        ({"q": {"x": 0, "y": 0, "z": 0, "w": 0}}, {"bad_quaternion": 1}),
        ({"q": {"x": 10, "y": 20, "z": 30, "w": 0}}, {"bad_quaternion": 1}),
        ({"q": {"x": "a", "y": 0, "z": 0, "w": 1}}, {"wrong_type": 1}),
        ({"mag": [21, "N/A", 43]}, {"wrong_type": 1}),
        ({"mag": [1e9, 0, 0]}, {"out_of_range": 1}),
        ({"mag": [21, -4], "q": {"w": 1}}, {"incomplete": 2}),
        ({"mag": [21, -4, 43, 5]}, {"wrong_type": 1}),
    ],
)
def test_e_a_quantity_that_is_not_required_is_left_out_and_the_sample_goes_on(
    rigs: Rigs, part: dict[str, Any], left_out: dict[str, int]
) -> None:
    quaternion = [f"q.{axis}" for axis in "xyzw"]
    more = {"mapping.orientation.paths": quaternion, "mapping.required": BOTH}
    rig = rigs(**at("acc", "gyr", "mag"), **more)
    ((topic, message),) = rig.send({"acc": [0, 0, 9.8], "gyr": [0, 0, 0.1], **part})
    assert topic == "data_raw"
    assert message.linear_acceleration.z == 9.8
    assert rig.reader.counts.left_out == left_out
    assert rig.reader.counts.published == rig.reader.counts.received == 1


def test_e_encoders_that_leave_zeros_out(rigs: Rigs, caplog: pytest.LogCaptureFixture) -> None:
    acc, gyr = [f"acc.{axis}" for axis in "xyz"], [f"gyr.{axis}" for axis in "xyz"]
    payload = {"acc": {"z": 9.8}, "gyr": {"x": 0.2, "y": 0.1}}
    rig = rigs(**at(acc, gyr, mapping__required=BOTH))
    assert rig.send(payload) == []
    assert rig.reader.counts.by_reason == {"incomplete": 1}
    assert any("mapping.absent:=zero" in message for message in caplog.messages)
    zero = rigs(**at(acc, gyr, mapping__required=BOTH, mapping__absent="zero"))
    published = zero.send(payload)
    assert acc_of(published) == [(0.0, 0.0, 9.8)]
    assert gyr_of(published) == [(0.2, 0.1, 0.0)]
    assert gyr_of(zero.send({"acc": {"z": 9.8}, "gyr": {}})) == [(0.0, 0.0, 0.0)]
    assert zero.send({"acc": {"z": 9.8}}) == []
    assert zero.send({"temp": 21.5}) == []
    assert zero.send({"acc": {"z": None}, "gyr": {}}) == []
    assert zero.reader.counts.by_reason == {"missing_group": 2, "no_imu_data": 1}


def test_e_zeros_of_flat_names_need_a_condition_and_lists_leave_nothing_out(rigs: Rigs) -> None:
    flat = rigs(**at(["ax", "ay", "az"], ["gx", "gy", "gz"], mapping__absent="zero"))
    ((_, message),) = flat.send({"az": 9.8})
    assert message.angular_velocity_covariance[0] == -1.0
    tagged = rigs(
        **at(
            [f"[t=imu].a{axis}" for axis in "xyz"],
            [f"[t=imu].g{axis}" for axis in "xyz"],
            mapping__absent="zero",
        )
    )
    ((_, message),) = tagged.send({"t": "imu", "az": 9.8})
    assert message.angular_velocity_covariance[0] == 0.0
    assert tagged.send({"t": "status"}) == []
    lists = rigs(**at("acc", mapping__absent="zero"))
    assert lists.send({"acc": [0.1, 0.2]}) == []
    assert lists.reader.counts.by_reason == {"incomplete": 1}


def test_e_a_simulator_that_prints_protobuf(rigs: Rigs) -> None:
    rig = rigs(
        **at(
            [f"linearAcceleration.{axis}" for axis in "xyz"],
            [f"angularVelocity.{axis}" for axis in "xyz"],
            mapping__orientation__paths=[f"orientation.{axis}" for axis in "xyzw"],
            mapping__absent="zero",
            mapping__numeric_strings=True,
            mapping__time__paths=["header.stamp.sec", "header.stamp.nsec"],
            time_source="device",
        )
    )
    ((topic, message),) = rig.send(
        b'{"header":{"stamp":{"sec":"1812345678"}},"orientation":{"w":1},'
        b'"angularVelocity":{},"linearAcceleration":{"z":9.8}}'
    )
    assert topic == "data"
    assert (message.orientation.w, message.angular_velocity.x) == (1.0, 0.0)
    assert message.header.stamp == Time(1_812_345_678, 0)


# F. Asked for, not done, not said.


def test_f_a_date_that_is_never_usable_is_said_in_the_log_and_in_health(
    rigs: Rigs, caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs(
        **at("acc", time_source="device", mapping__time__paths=["t"], mapping__time__unit="ms")
    )
    for number in range(25):
        rig.send({"acc": [0, 0, 9.8], "t": 12_345 + number})
    rig.pass_time(0.5)
    (said,) = [m for m in caplog.messages if "time_unusable" in m]
    assert "12.345 s after 1970 is an uptime, not a date" in said
    assert rig.reader.health.level is HealthLevel.WARN
    assert "an uptime, not a date" in rig.reader.health.message
    assert rig.reader.counts.time_unusable == 25
    rig.send({"acc": [0, 0, 9.8], "t": 1_700_000_000_000})
    rig.pass_time(0.5)
    assert rig.reader.health.message == "samples arrive"


@pytest.mark.parametrize(
    ("date", "why"),
    [
        (None, "nothing at t"),
        ("2025-10-01T12:00:00", "has no time zone"),
        ("N/A", "'N/A' is no date"),
        ("1812345678.12", "set mapping.numeric_strings"),
        (True, "True is no date"),
        (1_700_000_000_000, "after the year 9999; is mapping.time.unit right?"),
        ({"sec": 5}, "is no date"),
        (-(10**400), "a date before 1970"),
        (10**400, "after the year 9999"),
        (-1e300, "is no date"),
    ],
)
def test_f_why_a_date_is_unusable_is_said(
    rigs: Rigs, caplog: pytest.LogCaptureFixture, date: Any, why: str
) -> None:
    rig = rigs(
        **at("acc", time_source="device", mapping__time__paths=["t"], mapping__time__unit="s")
    )
    ((_, message),) = rig.send({"acc": [0, 0, 9.8], "t": date}, 5)
    assert message.header.stamp == Time(0, 5)
    assert any(why in said for said in caplog.messages)


@pytest.mark.parametrize(
    ("date", "stamp"),
    [
        ("1812345678.5", Time(1_812_345_678, 500_000_000)),
        (" 1812345678 ", Time(1_812_345_678, 0)),
        (1_812_345_678.5, Time(1_812_345_678, 500_000_000)),
        ("2027-06-07T05:21:18.25Z", Time(1_812_345_678, 250_000_000)),
        ("2027-06-07T10:51:18.25+05:30", Time(1_812_345_678, 250_000_000)),
    ],
)
def test_f_dates_may_be_texts(rigs: Rigs, date: Any, stamp: Time) -> None:
    rig = rigs(
        **at(
            "acc",
            time_source="device",
            mapping__time__paths=["t"],
            mapping__time__unit="s",
            mapping__numeric_strings=True,
        )
    )
    ((_, message),) = rig.send({"acc": [0, 0, 9.8], "t": date})
    assert message.header.stamp == stamp


def test_f_nanoseconds_in_a_text_keep_every_digit(rigs: Rigs) -> None:
    rig = rigs(
        **at(
            "acc",
            time_source="device",
            mapping__time__paths=["t"],
            mapping__time__unit="ns",
            mapping__numeric_strings=True,
        )
    )
    ((_, message),) = rig.send({"acc": [0, 0, 9.8], "t": "1812345678123456789"})
    assert message.header.stamp == Time(1_812_345_678, 123_456_789)


def test_f_keys_with_dots_have_a_notation_and_axes_can_be_negated(rigs: Rigs) -> None:
    rig = rigs(**at(['"accel.x"', '"accel.y"', '-"accel.z"'], ['"gyro (dps)"[0]', "-g.y", "g.z"]))
    published = rig.send(
        {"accel.x": 0.1, "accel.y": 0, "accel.z": -9.8, "gyro (dps)": [0.1], "g": {"y": 2, "z": 3}}
    )
    assert acc_of(published) == [(0.1, 0.0, 9.8)]
    assert gyr_of(published) == [(0.1, -2.0, 3.0)]


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"magnetic_field_stddev": [1e-6]}, "magnetic_field_stddev has no effect"),
        ({"magnetic_field_full_scale": 0.1}, "magnetic_field_full_scale has no effect"),
        ({"orientation_stddev": [0.1]}, "orientation_stddev has no effect"),
        ({"mapping.quaternion_tolerance": 0.1}, "mapping.quaternion_tolerance has no effect"),
        (
            {"mapping.time.paths": ["t"], "mapping.time.unit": "s"},
            "mapping.time.paths has no effect: time_source is arrival",
        ),
    ],
)
def test_f_what_has_no_effect_is_named_once(
    rigs: Rigs, caplog: pytest.LogCaptureFixture, parameters: dict[str, Any], said: str
) -> None:
    rig = rigs(**at("acc"), **parameters)
    rig.send({"acc": [0, 0, 9.8], "t": 1})
    assert len([message for message in caplog.messages if said in message]) == 1


def test_f_what_has_no_effect_in_a_mapping_is_refused(rigs: Rigs) -> None:
    for name, value in (
        ("mapping.magnetic_field.unit", "uT"),
        ("mapping.orientation.order", "wxyz"),
        ("mapping.time.interval", "5 ms"),
        ("mapping.time.unit", "s"),
    ):
        with pytest.raises(MappingError, match=f"{name} has no effect"):
            rigs(**at("acc"), **{name: value})


@pytest.mark.parametrize("comes_late", [False, True])
def test_f_a_quantity_that_is_asked_for_and_never_there_is_named_once(
    rigs: Rigs, caplog: pytest.LogCaptureFixture, *, comes_late: bool
) -> None:
    rig = rigs(
        preset="custom",
        **{
            "mapping.linear_acceleration.paths": ["acc"],
            "mapping.linear_acceleration.unit": "m/s^2",
            "mapping.angular_velocity.paths": ["gyr"],
            "mapping.angular_velocity.unit": "rad/s",
        },
    )
    for number in range(200):
        key = "gyr" if comes_late and number > 20 else "gyro"
        rig.send({"acc": [0.1, number / 100, 9.8], key: [0, 0, 0.1]}, (number + 1) * 10**7)
    said = [text for text in caplog.messages if "is mapped, but no sample has had it" in text]
    assert said == (
        []
        if comes_late
        else [
            "angular_velocity is mapped, but no sample has had it: "
            "angular_velocity: the payload has no 'gyr'; did you mean 'gyro'?"
        ]
    )


def test_f_a_quantity_of_a_preset_that_is_never_there_is_no_fault(
    rigs: Rigs, caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs(preset="ros")
    sample = {
        "linear_acceleration": {"x": 0, "y": 0, "z": 9.8},
        "angular_velocity": {"x": 0, "y": 0, "z": 0.1},
    }
    for number in range(60):
        sample["linear_acceleration"]["x"] = number / 100
        rig.send(sample, (number + 1) * 10**7)
    assert rig.reader.check_health().message == "samples arrive"
    assert not [text for text in caplog.messages if "asked for" in text]


@pytest.mark.parametrize(
    "line",
    [
        b'{"acc":[0,0,9.8],"gyr":[0,0,0.5],"acc":[0,0,3.1]}',
        b'{"acc":[0,0,9.8],"gyr":[0,0,0.5],"meta":{"acc":1,"acc":2}}',
        b'{"acc":[0,0,NaN],"acc":[0,0,9.8]}',
        b'[{"acc":[0,0,9.8],"acc":[0,0,9.8]}]',
    ],
)
def test_h_a_key_twice_is_the_reason_that_is_said(
    rigs: Rigs, caplog: pytest.LogCaptureFixture, line: bytes
) -> None:
    rig = rigs(
        preset="custom",
        **{
            "mapping.linear_acceleration.paths": ["acc"],
            "mapping.linear_acceleration.unit": "m/s^2",
        },
    )
    rig.send(line)
    (said,) = [text for text in caplog.messages if text.startswith("dropped")]
    assert "bad_json (the key 'acc' stands twice)" in said
