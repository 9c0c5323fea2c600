"""What `--topic-echo` prints of a sample."""

import json
import math

from rosbase.cli.monitor import message_to_json
from rosbase.messages import Header, Imu, MagneticField, Quaternion, Time, Vector3


def test_a_sample_is_one_line_of_json_with_the_names_of_ros() -> None:
    line = message_to_json(Imu(Header(Time(5, 6), "imu_link"), Quaternion(0.5, 0.5, 0.5, 0.5)))
    sample = json.loads(line)
    assert "\n" not in line
    assert sample["header"] == {"stamp": {"sec": 5, "nanosec": 6}, "frame_id": "imu_link"}
    assert sample["orientation"] == {"x": 0.5, "y": 0.5, "z": 0.5, "w": 0.5}
    assert sample["orientation_covariance"] == [0.0] * 9


def test_what_another_node_sends_that_is_no_number_is_null() -> None:
    covariance = (-math.inf, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, math.nan)
    field = MagneticField(Header(), Vector3(1e-5, math.inf, math.nan), covariance)
    sample = json.loads(message_to_json(field))
    assert sample["magnetic_field"] == {"x": 1e-5, "y": None, "z": None}
    assert sample["magnetic_field_covariance"] == [None, *[1.0] * 7, None]
