"""Our bytes, schemas and hashes beside those of rclpy and of rosbags, for every message class.

A thousand random messages of each class are compared; `nox -s wire` compares a million in all.
"""

import json
import os
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
import rclpy
from hypothesis import HealthCheck, given, settings

from rosbase.wire import deserialize, schema, serialize, type_hash
from rosbase.wire.description import describe
from support.mirrored_messages import mirrored
from support.plain_cdr import PlainCdr
from support.ros_messages import as_ros, ros_class
from support.wire_messages import CLASSES, Rolled, flat, made, messages_of, name_of

rosbags: Any = import_module("rosbags.typesys")
serialization: Any = import_module("rclpy.serialization")

# Bytes are those of every Python.
pytestmark = pytest.mark.once

STORE: Any = rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY)
CASES = int(os.environ.get("ROSBASE_WIRE_CASES", "1000"))
BY_ROS = [cls for cls in CLASSES if not name_of(cls).startswith("tf2_msgs/")]
BY_ROSBAGS = [cls for cls in CLASSES if name_of(cls) in STORE.types]
# rosbags keeps the `char` of these definitions; rosidl, and so rclpy, makes it uint8.
CHAR_OF_ROSBAGS = {"std_msgs/msg/Char", "service_msgs/msg/ServiceEventInfo"}
ALMOST_ALL = 100
# Arrays, bounded and unbounded sequences of all types, bounded and wide texts, empty messages.
OWN = [name for name in vars(import_module("test_msgs.msg")) if name[0].isupper()]
OWN = [name for name in OWN if "_" not in name]


def agrees_with_ros(message: Any) -> None:
    """Fails unless rclpy reads what we write, and we what rclpy writes, and the bytes are equal."""
    of = describe(type(message))
    theirs, values = as_ros(message, of), flat(message)
    ours = serialize(message)
    assert flat(serialization.deserialize_message(ours, type(theirs)), of) == values
    data = serialization.serialize_message(theirs)
    # The padding of rclpy holds what was in memory. Behind the message there is more of it: rclpy
    # estimates the length, and counts padding in front of elements even where there are none.
    assert len(ours) <= len(data)
    assert PlainCdr(message).without_padding(data)[: len(ours)] == ours
    assert flat(deserialize(data, type(message))) == values


def agrees_with_rosbags(message: Any) -> None:
    """Fails unless rosbags makes the same message of our bytes, and the same bytes of that."""
    ours = serialize(message)
    name = name_of(type(message))
    theirs = STORE.deserialize_cdr(ours, name)
    assert flat(theirs, describe(type(message))) == flat(message)
    assert bytes(STORE.serialize_cdr(theirs, name)) == ours


@pytest.mark.timeout(0)
@pytest.mark.parametrize("cls", BY_ROS, ids=name_of)
def test_random_messages_have_the_bytes_of_rclpy(cls: type) -> None:
    choose = Rolled(7)
    agrees_with_ros(cls())
    for _ in range(CASES):
        agrees_with_ros(made(describe(cls), choose))


@pytest.mark.parametrize("cls", BY_ROS, ids=name_of)
def test_extreme_messages_have_the_bytes_of_rclpy(cls: type) -> None:
    @settings(max_examples=20, suppress_health_check=list(HealthCheck), report_multiple_bugs=False)
    @given(messages_of(cls))
    def check(message: Any) -> None:
        agrees_with_ros(message)

    check()


@pytest.mark.parametrize("cls", BY_ROSBAGS, ids=name_of)
def test_random_messages_have_the_bytes_of_rosbags(cls: type) -> None:
    choose = Rolled(8)
    agrees_with_rosbags(cls())
    for _ in range(100):
        agrees_with_rosbags(made(describe(cls), choose))


def test_each_class_has_an_oracle_and_almost_all_have_two() -> None:
    assert {*BY_ROS, *BY_ROSBAGS} == set(CLASSES)
    assert len(BY_ROSBAGS) > ALMOST_ALL


@pytest.mark.parametrize("kind", ["attrs", "dataclass"])
@pytest.mark.parametrize("name", OWN)
def test_random_own_messages_have_the_bytes_of_rclpy(name: str, kind: str) -> None:
    cls = mirrored(f"test_msgs/msg/{name}", kind)
    choose = Rolled(9)
    for _ in range(50):
        agrees_with_ros(made(describe(cls), choose))


@pytest.mark.parametrize("name", OWN)
def test_the_hash_of_an_own_message_is_the_one_that_rclpy_publishes_with(
    name: str, context: Any
) -> None:
    node: Any = rclpy.create_node("hashes", context=context)
    try:
        node.create_publisher(ros_class(f"test_msgs/msg/{name}"), "topic", 1)
        (info,) = node.get_publishers_info_by_topic("/topic")
        assert str(info.topic_type_hash) == type_hash(mirrored(f"test_msgs/msg/{name}", "attrs"))
    finally:
        node.destroy_node()


@pytest.mark.parametrize("cls", BY_ROS, ids=name_of)
def test_the_defaults_and_the_constants_are_those_of_rclpy(cls: type) -> None:
    theirs = ros_class(name_of(cls))
    assert flat(cls()) == flat(theirs(), describe(cls))
    names = {name for name in vars(type(theirs)) if name.isupper() and not name.startswith("_")}
    of_ros = {name: getattr(theirs, name) for name in names if not name.endswith("__DEFAULT")}
    plain = {name: v[0] if isinstance(v, bytes) else v for name, v in of_ros.items()}
    assert {one.name: one.value for one in describe(cls).constants} == plain


def test_the_hash_is_the_one_that_rclpy_publishes_with(context: Any) -> None:
    node: Any = rclpy.create_node("hashes", context=context)
    try:
        for cls in BY_ROS:
            publisher = node.create_publisher(ros_class(name_of(cls)), "topic", 1)
            (info,) = node.get_publishers_info_by_topic("/topic")
            assert info.topic_type == name_of(cls)
            assert str(info.topic_type_hash) == type_hash(cls)
            node.destroy_publisher(publisher)
    finally:
        node.destroy_node()


def test_the_hash_is_the_one_in_the_type_descriptions_of_ros() -> None:
    hashes: dict[str, str] = {}
    for package in {name_of(cls).split("/")[0] for cls in BY_ROS}:
        files = list((Path(sys.prefix) / "share" / package).glob("*/*.json"))
        assert files
        for file in files:
            described = json.loads(file.read_text())["type_hashes"]
            hashes |= {one["type_name"]: one["hash_string"] for one in described}
    for cls in BY_ROS:
        assert type_hash(cls) == hashes[name_of(cls)]


def test_the_hash_is_the_one_of_rosbags_but_where_rosbags_and_rclpy_differ() -> None:
    found = {
        name_of(cls) for cls in BY_ROSBAGS if STORE.hash_rihs01(name_of(cls)) != type_hash(cls)
    }
    assert found == CHAR_OF_ROSBAGS & {name_of(cls) for cls in BY_ROSBAGS}


@pytest.mark.parametrize("cls", BY_ROSBAGS, ids=name_of)
def test_the_schema_is_the_one_of_rosbags(cls: type) -> None:
    text, _ = STORE.generate_msgdef(name_of(cls), ros_version=2)
    if name_of(cls) in CHAR_OF_ROSBAGS:
        text = text.replace("char", "uint8")
    assert schema(cls) == text
