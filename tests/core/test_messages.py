import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase import messages
from rosbase.messages import (
    COVARIANCE_NOT_REPORTED,
    DiagnosticStatus,
    Imu,
    MagneticField,
    Quaternion,
    Time,
)

# From common_interfaces (jazzy): msg/*.msg of std_msgs, geometry_msgs, sensor_msgs
# and diagnostic_msgs.
FIELDS = {
    "Bool": "data",
    "DiagnosticArray": "header status",
    "DiagnosticStatus": "level name message hardware_id values",
    "Header": "stamp frame_id",
    "JointState": "header name position velocity effort",
    "Joy": "header axes buttons",
    "KeyValue": "key value",
    "Point": "x y z",
    "PointStamped": "header point",
    "Pose": "position orientation",
    "PoseStamped": "header pose",
    "Quaternion": "x y z w",
    "String": "data",
    "Twist": "linear angular",
    "Vector3": "x y z",
}


@given(st.integers(-(10**18), 10**19))
def test_time_keeps_every_nanosecond(nanoseconds: int) -> None:
    time = Time.from_nanoseconds(nanoseconds)
    assert time.nanoseconds == nanoseconds
    assert 0 <= time.nanosec < 10**9


def test_defaults_are_those_of_ros() -> None:
    assert Imu().orientation == Quaternion(0.0, 0.0, 0.0, 1.0)
    assert Imu().angular_velocity_covariance == (0.0,) * 9
    assert COVARIANCE_NOT_REPORTED[0] == -1.0


@pytest.mark.parametrize("name", FIELDS)
def test_a_message_has_the_fields_of_ros_in_their_order(name: str) -> None:
    kind = getattr(messages, name)
    assert [field.name for field in attrs.fields(kind)] == FIELDS[name].split()
    assert kind() == kind()


def test_the_levels_of_a_diagnostic_status_are_those_of_ros() -> None:
    status = DiagnosticStatus()
    assert [status.OK, status.WARN, status.ERROR, status.STALE] == [0, 1, 2, 3]
    assert status.level == status.OK


@pytest.mark.parametrize("message", [Imu(), MagneticField()])
def test_messages_cannot_be_changed_by_a_subscriber(message: object) -> None:
    with pytest.raises(attrs.exceptions.FrozenInstanceError):
        message.header = None  # type: ignore[attr-defined]  # the mistake is the test


def test_a_covariance_has_nine_elements() -> None:
    with pytest.raises(ValueError, match="orientation_covariance takes 9 elements, not 2"):
        Imu(orientation_covariance=(1.0, 2.0))  # type: ignore[arg-type]  # the mistake is the test
