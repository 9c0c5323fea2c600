"""Why JSON is no sample: the step of a path that led nowhere, what is there, and odd values."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.imu.diagnosis.payload import diagnose_payload, mapped_by
from rosbase.imu.diagnosis.places import diagnose_path
from rosbase.imu.mapping import ImuMapping
from rosbase.mapping.assembly import Batch
from rosbase.mapping.paths import EACH, Steps
from rosbase.mapping.rejects import Reject
from support.strategies import json_values

EACH_V = ("p", EACH, "v")
INNER = '{"acc":{"x":0.1,"y":0.2,"z":9.8}}'

LOST: dict[str, tuple[Any, Steps, str]] = {
    "no samples": ({"acc": []}, ("acc", EACH), "acc is an empty list"),
    "no elements": ({"p": []}, EACH_V, "p is an empty list"),
    "an object for a list": ({"p": {"v": [1]}}, EACH_V, "p is an object of 'v'; [*] takes a list"),
    "digits for a list": ({"p": {"0": {"v": 1}}}, EACH_V, "p is an object of '0'; [*] takes"),
    "a number for a list": ({"p": 5}, EACH_V, "p is a number; [*] takes a list"),
    "null for a list": ({"p": None}, EACH_V, "p is null; [*] takes a list"),
    "the top for a list": ({"v": 5}, (EACH, "v"), "the payload is an object of 'v'; [*] takes"),
    "in elements": ({"p": [{"V": 1}]}, EACH_V, "p[*] has no 'v'; did you mean 'V'?"),
    "another key": ({"a": 1, "b": 2}, ("acc",), "the payload has no 'acc', but 'a', 'b'"),
    "nothing": ({}, ("acc",), "the payload has no 'acc', but nothing at all"),
    "inside": ({"acc": {"u": 1}}, ("acc", "x"), "acc has no 'x', but 'u'"),
    "case": ({"Accel": {"x": 1}}, ("accel", "x"), "did you mean 'Accel'?"),
    "camels": ({"linearAcceleration": {}}, ("linear_acceleration", "x"), "'linearAcceleration'?"),
    "spelling": ({"acelleration": {}}, ("acceleration", "x"), "did you mean 'acelleration'?"),
    "dots": ({"acc.x": 1, "acc.y": 2}, ("acc", "x"), 'a key with dots: write "acc.x" in the path'),
    "dots inside": ({"imu": {"acc.x": 1}}, ("imu", "acc", "x"), 'write "acc.x" in the path'),
    "wrapped": ({"data": {"acc": {"x": 1}}}, ("acc", "x"), "there is one at 'data.acc.x'"),
    "wrapped in a list": ([{"acc": {"x": 1}}], ("acc", "x"), "its elements have it"),
    "deep": ({"a": [{"b": {"acc": [1]}}]}, ("acc", 0), "there is one at 'a[0].b.acc[0]'"),
    "in a text": ({"payload": INNER}, ("acc", "x"), "'payload', a text that holds JSON"),
    "through a text": ({"payload": INNER}, ("payload", "acc"), "payload is a text that holds"),
    "a short list": ({"acc": [1, 2]}, ("acc", 2), "acc is a list of 2, without '[2]'"),
    "a list for an object": ({"acc": [1, 2, 3]}, ("acc", "x"), "acc is a list, without 'x'"),
    "a number": ({"acc": 5}, ("acc", "x"), "acc is a number, without 'x'"),
    "null": ({"acc": None}, ("acc", "x"), "acc is null, without 'x'"),
    "a word": ({"acc": "off"}, ("acc", "x"), "acc is the text 'off', without 'x'"),
    "hostile keys": ({"\x1b[31m\n\u202e": 1}, ("acc",), r"'\x1b[31m\n\u202e'"),
}


@pytest.mark.parametrize("name", LOST)
def test_a_path_that_leads_nowhere_says_where_it_ends_and_what_is_there(name: str) -> None:
    payload, steps, said = LOST[name]
    found = diagnose_path(payload, steps)
    assert found is not None
    assert said in found.text
    assert found.text.isprintable()


def test_a_path_that_leads_on_says_nothing() -> None:
    assert diagnose_path({"acc": [{"x": None}]}, ("acc", 0, "x")) is None


MAPPING = ImuMapping(
    linear_acceleration_paths=("acc.x", "acc.y", "acc.z"),
    linear_acceleration_unit="m/s^2",
    angular_velocity_paths=("gyr",),
    angular_velocity_unit="rad/s",
    required=("angular_velocity", "linear_acceleration"),
)

REFUSED: dict[str, tuple[Any, str, str]] = {
    "nothing known": ({"temp": 21.5}, "no_imu_data", "angular_velocity: the payload has no 'gyr'"),
    "one is missing": (
        {"acc": {"x": 0, "y": 0, "z": 9.8}},
        "missing_group",
        "angular_velocity: the payload has no 'gyr', but 'acc'",
    ),
    "another case": (
        {"Acc": {"x": 0, "y": 0, "z": 9.8}, "gyr": [0, 0, 0]},
        "missing_group",
        "linear_acceleration: the payload has no 'acc'; did you mean 'Acc'?",
    ),
    "a component": (
        {"acc": {"x": 0, "y": 0, "Z": 9.8}, "gyr": [0, 0, 0]},
        "incomplete",
        "acc has no 'z'; did you mean 'Z'?",
    ),
    "units": (
        {"acc": {"x": "0.1 m/s2", "y": 0, "z": 9.8}, "gyr": [0, 0, 0]},
        "wrong_type",
        "'0.1 m/s2' is a number with its unit",
    ),
    "degrees": (
        {"acc": {"x": 0, "y": 0, "z": 9.8}, "gyr": ["1.5\u00b0/s", 0, 0]},
        "wrong_type",
        "'1.5\u00b0/s' is a number with its unit",
    ),
    "quotes": (
        {"acc": {"x": 0, "y": 0, "z": "9.81"}, "gyr": [0, 0, 0]},
        "wrong_type",
        "'9.81' is a number in quotes: set mapping.numeric_strings to true",
    ),
    "commas": (
        {"acc": {"x": 0, "y": 0, "z": "9,81"}, "gyr": [0, 0, 0]},
        "wrong_type",
        "'9,81' has a decimal comma",
    ),
    "no reading": (
        {"acc": {"x": "N/A", "y": 0, "z": 9.8}, "gyr": [0, 0, 0]},
        "wrong_type",
        "'N/A' in place of a number: the device has no reading",
    ),
    "a word": (
        {"acc": {"x": "left", "y": 0, "z": 9.8}, "gyr": [0, 0, 0]},
        "wrong_type",
        "the text 'left' in place of a number",
    ),
    "commas in a list": (
        {"acc": {"x": 0, "y": 0, "z": 9.8}, "gyr": [0, 12, 0, 5, 1, 7]},
        "wrong_type",
        "a list of 6 whole numbers; are they decimals with a comma?",
    ),
    "four of three": (
        {"acc": {"x": 0, "y": 0, "z": 9.8}, "gyr": [0.5, 0, 0, 21.5]},
        "wrong_type",
        "a list of 4",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_payload_that_is_refused_says_what_to_look_at(name: str) -> None:
    payload, reason, said = REFUSED[name]
    reject = MAPPING.compile()(json.dumps(payload).encode())
    assert isinstance(reject, Reject)
    assert reject.reason == reason
    cause = diagnose_payload(payload, reject, mapped_by(MAPPING))
    assert cause is not None
    assert said in cause.text
    assert cause.text.isprintable()


@pytest.mark.parametrize(
    ("paths", "payload", "said"),
    [
        (
            ("x[*]", "y[*]", "z[*]"),
            {"x": [1, 2], "y": [1, 2], "Z": [1, 2]},
            "linear_acceleration lacks z[*]: the payload has no 'z'; did you mean 'Z'?",
        ),
        (
            ("a.x[*]", "a.y[*]", "a.z[*]"),
            {"a": {"x": [1], "Y": [1], "z": [1]}},
            "linear_acceleration lacks a.y[*]: a has no 'y'; did you mean 'Y'?",
        ),
        (
            ("d[*].x", "d[*].y", "d[*].z"),
            {"d": [{"x": 1, "y": 2, "Z": 9.8}]},
            "linear_acceleration lacks d[*].z",
        ),
    ],
)
def test_what_a_message_of_several_samples_lacks_is_named(
    paths: tuple[str, ...], payload: Any, said: str
) -> None:
    mapping = ImuMapping(linear_acceleration_paths=paths, linear_acceleration_unit="m/s^2")
    batch = mapping.compile()(json.dumps(payload).encode())
    assert isinstance(batch, Batch)
    reject = batch.samples[0]
    assert isinstance(reject, Reject)
    cause = diagnose_payload(payload, reject, mapped_by(mapping))
    assert cause is not None
    assert cause.text.startswith(said)


@given(json_values, st.sampled_from(["no_imu_data", "missing_group", "incomplete", "wrong_type"]))
def test_no_payload_makes_it_raise(payload: object, reason: str) -> None:
    for detail in ("", "angular_velocity", "linear_acceleration: text", "orientation"):
        cause = diagnose_payload(payload, Reject(reason, detail), mapped_by(MAPPING))
        assert cause is None or cause.text.isprintable()
