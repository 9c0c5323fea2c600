import math
import os
import subprocess
import sys
from array import array
from importlib import import_module
from typing import Any

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase import messages
from rosbase.messages import (
    Bool,
    DiagnosticArray,
    DiagnosticStatus,
    Header,
    Imu,
    JointState,
    Joy,
    KeyValue,
    MagneticField,
    Pose,
    Quaternion,
    String,
    Time,
    Twist,
    Vector3,
)
from rosbase_ros2.conversion import Conversions, Converter
from support import strategies

serialization: Any = import_module("rclpy.serialization")
numpy: Any = import_module("numpy")
diagnostic_msgs: Any = import_module("diagnostic_msgs.msg")
geometry_msgs: Any = import_module("geometry_msgs.msg")
std_msgs: Any = import_module("std_msgs.msg")

CONVERSIONS = Conversions()
TYPES = sorted(strategies.messages, key=lambda kind: kind.__name__)


def over_the_network(message: object) -> object:
    """What another program would get."""
    converter = CONVERSIONS.of(type(message))
    data = serialization.serialize_message(converter.to_ros(message))
    return converter.from_ros(serialization.deserialize_message(data, converter.ros_type))


def test_every_message_that_is_compared_here_has_a_converter() -> None:
    # Not what else is imported: a message is imported when it is used.
    found = [getattr(messages, kind.__name__) for kind in TYPES]
    assert [CONVERSIONS.of(kind).msg_type for kind in found] == TYPES


@pytest.mark.parametrize("kind", TYPES)
@given(data=st.data())
def test_a_message_arrives_as_it_was_sent(kind: type, data: st.DataObject) -> None:
    message = data.draw(strategies.messages[kind])
    # repr tells NaN from numbers and -0.0 from 0.0, and 1 from 1.0.
    assert repr(over_the_network(message)) == repr(message)


@pytest.mark.parametrize("kind", TYPES)
def test_defaults_are_those_of_ros(kind: type) -> None:
    converter = CONVERSIONS.of(kind)
    assert converter.from_ros(converter.ros_type()) == kind()


# What may not be in a field, by the type of the field; ROS would send most of it as garbage.
WRONG: dict[type, list[Any]] = {
    float: [True, None, "1.0", b"1", 1j, [1.0], numpy.bool_(True)],
    int: [True, None, 1.0, "1", -(2**31) - 1, 2**32, 10**5000],
    bool: [0, 1, None, ""],
    str: [1, None, b"text", "a\0b", "\ud800"],
}


def places(message: Any, where: str) -> list[tuple[str, type, Any]]:
    """Each value in a message: its name, its type, and how to put another one there."""
    found: list[tuple[str, type, Any]] = []
    for field in attrs.fields(type(message)):
        value = getattr(message, field.name)
        into = _evolve(message, field.name)
        name = f"{where}.{field.name}"
        found.append((name, object, into))
        if attrs.has(type(value)):
            inner = places(value, name)
        elif isinstance(value, tuple):
            first = attrs.has(type(value[0]))
            inner = places(value[0], name) if first else [(name, type(value[0]), _alone)]
            into = _head(into, value[1:])
        else:
            inner = [(name, type(value), _alone)]
        found += [(n, kind, _after(put, into)) for n, kind, put in inner]
    return found


def _evolve(message: Any, name: str) -> Any:
    return lambda value: attrs.evolve(message, **{name: value})


def _alone(value: Any) -> Any:
    return value


def _head(put: Any, rest: tuple[Any, ...]) -> Any:
    return lambda value: put((value, *rest))


def _after(first: Any, then: Any) -> Any:
    return lambda value: then(first(value))


KEY_VALUE = KeyValue("temperature", "20")
STATUS = DiagnosticStatus(level=DiagnosticStatus.WARN, values=(KEY_VALUE,))
FULL: list[Any] = [
    Bool(),
    DiagnosticArray(status=(STATUS,)),
    Imu(),
    JointState(name=("elbow",), position=(1.0,), velocity=(1.0,), effort=(1.0,)),
    Joy(axes=(1.0,), buttons=(1,)),
    MagneticField(),
    Pose(),
    String(),
    Twist(),
]


@pytest.mark.parametrize("message", FULL, ids=lambda message: type(message).__name__)
def test_a_value_of_the_wrong_kind_is_refused_by_the_name_of_its_field(message: Any) -> None:
    converter = CONVERSIONS.of(type(message))
    for where, kind, put in places(message, type(message).__name__):
        for value in WRONG.get(kind, []):
            with pytest.raises((TypeError, ValueError)) as refused:
                converter.to_ros(put(value))
            # A message in a tuple is named by its own type.
            last = where.rpartition(".")[2]
            assert f"{last} takes " in str(refused.value)
            assert "\n" not in str(refused.value)


def test_a_bool_of_numpy_is_sent_as_one_of_python() -> None:
    message: Any = Bool(numpy.bool_(True))
    assert over_the_network(message) == Bool(True)


def test_the_field_is_named_from_the_message_on() -> None:
    imu = Imu(angular_velocity=Vector3(0.0, None, 0.0))  # type: ignore[arg-type]  # the mistake is the test
    with pytest.raises(TypeError, match=r"^Imu\.angular_velocity\.y takes numbers, not None$"):
        CONVERSIONS.of(Imu).to_ros(imu)
    pose = Pose(orientation=Vector3())  # type: ignore[arg-type]  # the mistake is the test
    with pytest.raises(TypeError, match=r"^Pose\.orientation takes messages of type Quaternion"):
        CONVERSIONS.of(Pose).to_ros(pose)


def test_a_message_of_another_type_is_refused() -> None:
    for wrong in (None, Twist(), CONVERSIONS.of(Imu).to_ros(Imu())):
        with pytest.raises(TypeError, match=r"^Imu takes messages of type Imu, not "):
            CONVERSIONS.of(Imu).to_ros(wrong)


@pytest.mark.parametrize("value", ["elbow", b"ab", None, {"elbow": 1}, 1, {1.0}, iter([1.0])])
def test_only_a_list_of_values_goes_into_a_list(value: Any) -> None:
    for field in ("name", "position"):
        # Past the constructor, which refuses it too.
        wrong = JointState()
        object.__setattr__(wrong, field, value)
        with pytest.raises(TypeError, match=rf"^JointState\.{field} takes a tuple"):
            CONVERSIONS.of(JointState).to_ros(wrong)


@pytest.mark.parametrize("stamp", [Time(2**31, 0), Time(-(2**31) - 1, 0), Time(0, -1)])
def test_a_time_that_ros_cannot_hold_is_refused(stamp: Time) -> None:
    with pytest.raises(ValueError, match=r"Header\.stamp\.(nano)?sec takes whole numbers from"):
        CONVERSIONS.of(Header).to_ros(Header(stamp))


def test_a_number_too_large_for_its_float_is_refused() -> None:
    with pytest.raises(ValueError, match=r"Joy\.axes takes numbers that a 32-bit float can hold"):
        CONVERSIONS.of(Joy).to_ros(Joy(axes=(1e39,)))
    with pytest.raises(ValueError, match=r"Vector3\.x takes numbers that a float can hold"):
        CONVERSIONS.of(Vector3).to_ros(Vector3(10**400))


def test_whole_numbers_and_those_of_numpy_become_floats() -> None:
    sent = Vector3(1, numpy.float32(0.5), numpy.int64(2))
    assert repr(over_the_network(sent)) == repr(Vector3(1.0, 0.5, 2.0))
    joints = JointState(
        position=numpy.array([1, 2]),
        velocity=[1, 2.5],  # type: ignore[arg-type]  # a list where a tuple is declared
        effort=array("f", [0.5]),  # type: ignore[arg-type]  # an array where a tuple is declared
    )
    expected = JointState(position=(1.0, 2.0), velocity=(1.0, 2.5), effort=(0.5,))
    assert repr(over_the_network(joints)) == repr(expected)
    imu = Imu(orientation_covariance=numpy.zeros(9, dtype=numpy.float32))
    assert repr(over_the_network(imu)) == repr(Imu())


def test_nan_is_let_through() -> None:
    sent = MagneticField(magnetic_field=Vector3(math.nan, 1e-5, math.nan))
    assert repr(over_the_network(sent)) == repr(sent)


def test_a_ros_message_is_passed_through() -> None:
    converter = CONVERSIONS.of(std_msgs.String)
    message = std_msgs.String(data="as it is")
    assert converter.msg_type is converter.ros_type is std_msgs.String
    assert converter.to_ros(message) is message
    assert converter.from_ros(message) is message


@pytest.mark.parametrize("kind", [int, JointState | None, "Imu", Converter])
def test_an_unknown_type_is_refused_in_one_line(kind: Any) -> None:
    with pytest.raises(TypeError, match=r"^[^\n]*, and no plugin has a conversion$"):
        CONVERSIONS.of(kind)


def test_a_converter_is_made_once() -> None:
    conversions = Conversions()
    assert conversions.of(Imu) is conversions.of(Imu)


@attrs.frozen
class Arrow:
    position: Vector3
    orientation: Quaternion


def knowing(given: dict[type, Any]) -> Conversions:
    """Conversions for which plugins have those."""
    return Conversions(lambda kind, accept: accept(given[kind]) if kind in given else None)


def test_a_class_of_ones_own_is_converted_to_the_ros_class_with_its_fields() -> None:
    conversions = knowing({Arrow: geometry_msgs.Pose})
    converter = conversions.of(Arrow)
    arrow = Arrow(Vector3(1.0, 2.0, 3.0), Quaternion())
    ros = converter.to_ros(arrow)
    assert ros.position == geometry_msgs.Point(x=1.0, y=2.0, z=3.0)
    assert converter.from_ros(ros) == arrow


def test_a_class_whose_fields_differ_from_those_of_ros_is_refused() -> None:
    with pytest.raises(TypeError, match="Arrow and Twist of ROS differ in fields: angular, lin"):
        Conversions().derive(Arrow, geometry_msgs.Twist)
    with pytest.raises(TypeError, match="no attrs class"):
        Conversions().derive(int, geometry_msgs.Twist)


@attrs.frozen
class Field:
    header: Header
    magnetic_field: Vector3
    magnetic_field_covariance: tuple[float, ...]


def test_an_array_of_fixed_size_takes_just_as_many_elements() -> None:
    converter = Conversions().derive(Field, CONVERSIONS.of(MagneticField).ros_type)
    for size in (0, 8, 10):
        with pytest.raises(ValueError, match=rf"covariance takes 9 elements, not {size}$"):
            converter.to_ros(Field(Header(), Vector3(), (1.0,) * size))


@attrs.frozen
class Frame:
    name: str


@attrs.frozen
class Stamped:
    header: Frame
    vector: Vector3


@attrs.frozen
class Row:
    status: tuple[Frame, ...]
    header: Header


FRAME = Converter(
    Frame,
    std_msgs.Header,
    lambda frame: std_msgs.Header(frame_id=f"robot1/{frame.name}"),
    lambda ros: Frame(ros.frame_id.removeprefix("robot1/")),
)


def test_a_converter_by_hand_is_used_inside_other_messages_too() -> None:
    conversions = knowing({Frame: FRAME, Stamped: geometry_msgs.Vector3Stamped})
    converter = conversions.of(Stamped)
    stamped = Stamped(Frame("imu_link"), Vector3(1.0, 2.0, 3.0))
    ros = converter.to_ros(stamped)
    assert ros.header.frame_id == "robot1/imu_link"
    assert converter.from_ros(ros) == stamped
    with pytest.raises(TypeError, match=r"^Stamped\.header takes messages of type Frame"):
        converter.to_ros(Stamped(None, Vector3()))  # type: ignore[arg-type]  # the mistake is the test


def test_what_a_plugin_converts_to_another_class_than_the_field_has_is_refused() -> None:
    conversions = knowing({Frame: FRAME, Row: diagnostic_msgs.DiagnosticArray})
    with pytest.raises(
        TypeError, match=r"^Row\.status is diagnostic_msgs/DiagnosticStatus in ROS, which is not"
    ):
        conversions.of(Row)


def test_a_plugin_is_asked_once_and_only_about_what_is_not_known() -> None:
    asked: list[type] = []

    def ask(kind: type, accept: Any) -> Any:
        asked.append(kind)
        return accept({Frame: FRAME, Stamped: geometry_msgs.Vector3Stamped}[kind])

    conversions = Conversions(ask)
    for kind in (Imu, std_msgs.String, Stamped, Stamped, Frame):
        conversions.of(kind)
    assert asked == [Stamped, Frame]


@pytest.mark.parametrize("given", [None, Frame("x"), Frame, FRAME])
def test_what_is_neither_a_ros_class_nor_a_converter_for_the_class_is_refused(given: Any) -> None:
    with pytest.raises(TypeError, match="neither a ROS message class nor a Converter"):
        knowing({Stamped: given}).of(Stamped)


# What is essential above, in a Python of its own: ROS reads the variable when it is imported.
EVERY_TYPE = """
import sys
from rclpy.serialization import deserialize_message, serialize_message
from rosbase.messages import *
from rosbase_ros2.conversion import Conversions

conversions = Conversions()
nine = tuple(range(9))
for message in (
    Bool(True), String("text"), Joy(Header(Time(1, 2), "pad"), (1, 0.5), (0, 1)),
    Imu(Header(Time(-1, 5), "imu"), Quaternion(1, 0, 0, 0), nine, Vector3(1, 2, 3)),
    MagneticField(magnetic_field=Vector3(1, 2, 3), magnetic_field_covariance=nine),
    JointState(name=("a", "b"), position=(1, 2.5)), PoseStamped(pose=Pose(Point(1, 2, 3))),
    PointStamped(point=Point(1, 2, 3)), Twist(Vector3(1, 0, 0)),
    DiagnosticArray(status=(DiagnosticStatus(2, "a", values=(KeyValue("k", "v"),)),)),
):
    converter = conversions.of(type(message))
    ros = converter.to_ros(message)
    assert ros._check_fields is (sys.argv[1] == "1")
    back = deserialize_message(serialize_message(ros), converter.ros_type)
    assert converter.from_ros(back) == message, message
for wrong in (True, None, "1"):
    try:
        conversions.of(Twist).to_ros(Twist(Vector3(wrong)))
    except TypeError as exc:
        assert "Twist.linear.x takes numbers" in str(exc)
    else:
        raise SystemExit(f"{wrong!r} got through")
"""


def run_python(script: str, *arguments: str, **variables: str) -> None:
    environment = {k: v for k, v in os.environ.items() if k != "ROS_PYTHON_CHECK_FIELDS"}
    environment |= {"PYTHONPATH": os.pathsep.join(sys.path)} | variables
    command = [sys.executable, "-c", script, *arguments]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr


def test_it_is_the_same_with_the_field_checks_of_ros_on() -> None:
    run_python(EVERY_TYPE, "1", ROS_PYTHON_CHECK_FIELDS="1")


def test_it_is_the_same_with_the_field_checks_of_ros_off() -> None:
    run_python(EVERY_TYPE, "0")


def test_only_the_ros_packages_that_are_needed_are_imported() -> None:
    run_python(
        "import sys; from rosbase_ros2.conversion import Conversions;"
        "from rosbase.messages import String; conversions = Conversions();"
        "assert not [name for name in sys.modules if name.endswith('_msgs.msg')];"
        "conversions.of(String);"
        "assert 'std_msgs.msg' in sys.modules;"
        "assert 'sensor_msgs.msg' not in sys.modules"
    )
