"""Payloads for tests: a good one, and every fault that must be survived."""

import json
from typing import Any

GOOD: dict[str, Any] = {
    "header": {"stamp": {"sec": 1_700_000_000, "nanosec": 5}, "frame_id": "somewhere"},
    "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
    "angular_velocity": {"x": 0.1, "y": -0.2, "z": 0.3},
    "linear_acceleration": {"x": 0.0, "y": 0.0, "z": 9.80665},
}


def payload(**changes: Any) -> dict[str, Any]:
    """The good payload with other groups; None leaves a group out."""
    changed = {**GOOD, **changes}
    return {key: value for key, value in changed.items() if value is not None}


def frame(**changes: Any) -> bytes:
    """The same as a line, without its end."""
    return json.dumps(payload(**changes)).encode()


def vector(x: Any = 0.0, y: Any = 0.0, z: Any = 0.0) -> dict[str, Any]:
    return {"x": x, "y": y, "z": z}


GOOD_FRAME = frame()
GOOD_DATE_NS = 1_700_000_000_000_000_005

# By a name of the fault: the line, and the reason under which it is counted.
FAULTS: dict[str, tuple[bytes, str]] = {
    "P1 nan as printf writes it": (
        GOOD_FRAME.replace(b"9.80665", b"nan"),
        "bad_json",
    ),
    "P2 NaN": (frame(linear_acceleration=vector(z=float("nan"))), "non_finite"),
    "P2 Infinity": (frame(angular_velocity=vector(x=float("inf"))), "non_finite"),
    "P2 1e999": (GOOD_FRAME.replace(b"9.80665", b"1e999"), "non_finite"),
    "P3 text": (frame(linear_acceleration=vector(z="9.81")), "wrong_type"),
    "P3 null": (frame(linear_acceleration=vector(z=None)), "wrong_type"),
    "P3 true": (frame(linear_acceleration=vector(z=True)), "wrong_type"),
    "P3 list": (frame(linear_acceleration=vector(z=[9.81])), "wrong_type"),
    "P4 half a vector": (frame(linear_acceleration={"x": 0.0, "y": 0.0}), "incomplete"),
    "P4 required group absent": (frame(angular_velocity=None), "missing_group"),
    "P4 another message type": (b'{"T":1001,"L":1,"R":2}', "no_imu_data"),
    "P7 deep nesting": (b'{"a":' + b"[" * 60_000, "too_deep"),
    "P7 5000 digits": (GOOD_FRAME.replace(b"9.80665", b"9" * 5000), "out_of_range"),
    "P7 400 digits": (GOOD_FRAME.replace(b"9.80665", b"9" * 400), "out_of_range"),
    "P10 opening of pretty-printed JSON": (b"{", "multi_line"),
    "P10 member of pretty-printed JSON": (b'"Ax":\t0.1,', "multi_line"),
    "P10 end of pretty-printed JSON": (b"}", "multi_line"),
    "P10 member with an object": (b'"accel": {"x":0, "y":0, "z":1}', "multi_line"),
    "P10 element of a list": (b"-0.5,", "multi_line"),
    "P7 beyond the full scale": (frame(angular_velocity=vector(z=1800.0)), "out_of_range"),
    "a key twice": (GOOD_FRAME[:-1] + b',"header":{}}', "bad_json"),
    "P7 absurd": (frame(linear_acceleration=vector(z=1e300)), "out_of_range"),
    "S8 boot text in brackets": (b"[E][Wire.cpp:513] requestFrom failed", "not_data"),
    "S8 boot text": (b"ets Jul 29 2019 12:21:46", "not_data"),
    "S8 sensor found": (b"MPU6050 Found!", "not_data"),
    "S9 end of a first line": (b'0.1,"z":9.8}}', "not_data"),
    "S10 noise": (b"\xff\xfe\x80{}", "not_utf8"),
    "cut short": (GOOD_FRAME[:60], "bad_json"),
    "a lone number": (b"5", "not_data"),
    "an empty object": (b"{}", "no_imu_data"),
}

# Faults of the orientation, without which a sample may go out.
ORIENTATION_FAULTS: dict[str, tuple[bytes, str]] = {
    "P4 half a quaternion": (frame(orientation={"w": 1.0}), "incomplete"),
    "P5 zero quaternion": (frame(orientation={**vector(), "w": 0.0}), "bad_quaternion"),
    "P5 not unit": (frame(orientation={**vector(x=0.9), "w": 0.9}), "bad_quaternion"),
    "P5 Euler angles in degrees": (
        frame(orientation={**vector(10.0, 20.0, 30.0), "w": 0.0}),
        "bad_quaternion",
    ),
    "P3 a quaternion with a text": (frame(orientation={**vector(), "w": "1"}), "wrong_type"),
    "P2 NaN": (frame(orientation={**vector(), "w": float("nan")}), "non_finite"),
}
