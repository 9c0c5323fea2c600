"""Values that YAML would take for another type, given to the reader without ROS."""

from pathlib import Path
from typing import Any

import pytest

from rosbase.cli.arguments import check_given, read_given
from rosbase.errors import ConfigurationError, ParameterError
from rosbase.imu.settings import reader_parameters
from rosbase.plugins import installed_plugins


def values_of(*assignments: str, file: Path | None = None) -> dict[str, Any]:
    """What `rosbase imu` hands to the reader."""
    return check_given(reader_parameters(installed_plugins()), read_given(assignments, file))


@pytest.mark.parametrize(
    ("assignment", "value"),
    [
        ("plausibility:=off", "off"),
        ("dtr:=off", "off"),
        ("rts:=on", "on"),
        ("mqtt_version:=5", "5"),
        ("frame_id:=no", "no"),
        ("frame_id:=0042", "0042"),
        ("frame_id:=1e3", "1e3"),
        ("mqtt_topic:=#", "#"),
        ("mqtt_topic:=1_000", "1_000"),
        ("mapping.orientation.paths:=[]", []),
        ("mapping.linear_acceleration.paths:=[x, y, z]", ["x", "y", "z"]),
        ("mapping.angular_velocity.paths:=[n, on, 1]", ["n", "on", "1"]),
        ("mapping.select:=[type=101]", ["type=101"]),
        ("stale_timeout:=2", 2.0),
        ("mapping.sentinels:=[-999, 0.5]", [-999.0, 0.5]),
        ("mapping.numeric_strings:=yes", True),
        ("baudrate:=0x1C200", 115_200),
    ],
)
def test_a_value_is_of_the_declared_type(assignment: str, value: Any) -> None:
    ((_, found),) = values_of(assignment).items()
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(
    ("assignment", "said"),
    [
        ("baudrate:=0115200", "0115200 is octal in YAML; write 115200, if it is meant"),
        ("baudrate:=115200.0", "takes a whole number, not 115200.0"),
        ("stale_timeout:=off", "takes a number, not 'off'"),
        ("mapping.numeric_strings:=1", "takes true or false, not 1"),
        ("plausibility:=false", "is one of warn, reject, off, not 'false'"),
    ],
)
def test_what_is_none_is_refused_in_one_line(assignment: str, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        values_of(assignment)


def test_a_file_says_the_same_in_quotes_and_a_choice_without(tmp_path: Path) -> None:
    file = tmp_path / "imu.toml"
    file.write_text(
        'plausibility = "off"\nmqtt_version = 5\ndtr = false\nstale_timeout = 2\n'
        '[mapping.orientation]\npaths = []\n[mapping.linear_acceleration]\npaths = ["x", "y"]\n'
    )
    assert values_of(file=file) == {
        "plausibility": "off",
        "mqtt_version": "5",
        "dtr": "off",
        "stale_timeout": 2.0,
        "mapping.orientation.paths": [],
        "mapping.linear_acceleration.paths": ["x", "y"],
    }
    file.write_text("frame_id = 42\n")
    with pytest.raises(ParameterError, match="takes text, not 42; write text in quotes"):
        values_of(file=file)


def test_a_parameter_file_of_ros_is_read_for_the_node_of_the_reader(tmp_path: Path) -> None:
    file = tmp_path / "imu.yaml"
    file.write_text(
        "/**:\n  ros__parameters: {frame_id: every, plausibility: off}\n"
        "/lifecycle_manager:\n  ros__parameters:\n    comm_t: 'serial'\n    frame_id: '0042'\n"
        "    stale_timeout: 2\n    mapping: {select: [type=101]}\n"
        "/camera:\n  ros__parameters: {fps: 30}\n"
    )
    assert read_given([], file)["comm_t"].text == "serial"
    assert values_of("stale_timeout:=3", file=file) == {
        "plausibility": "off",
        "comm_t": "serial",
        "frame_id": "0042",
        "stale_timeout": 3.0,
        "mapping.select": ["type=101"],
    }
    file.write_text("/camera:\n  ros__parameters: {fps: 30}\n")
    with pytest.raises(ConfigurationError, match="has no parameters for /lifecycle_manager"):
        values_of(file=file)
