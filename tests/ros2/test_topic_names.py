"""The core's rules for topic names beside those of rcl and rmw."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from rclpy.exceptions import InvalidTopicNameException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.validate_full_topic_name import validate_full_topic_name

from rosbase import BackendError, resolve_topic
from rosbase.contracts.names import MAX_TOPIC_LENGTH
from rosbase.messages import String
from rosbase_ros2.backend import Ros2Backend

NAMES = ("a", "B", "_", "__", "1", "imu/data", "a" * 60)
SIGNS = ("/", "//", "~", "~/", "{node}", "{ns}", "{namespace}", "{x}", "{", "}")
FOREIGN = (" ", ".", "-", "ä", "\n", "\0", "\ud800", "\uff11")
parts = st.sampled_from((*NAMES, *SIGNS, *FOREIGN))
topics = st.lists(parts, max_size=8).map("".join) | st.text(max_size=8)
tokens = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,20}", fullmatch=True)
spaces = st.lists(tokens, max_size=3).map(lambda names: "".join(f"/{name}" for name in names))


def by_ros(topic: str, node: str, space: str) -> str | None:
    """The full name that ROS makes of it; None if it takes no such name."""
    try:
        full: str = expand_topic_name(topic, node, space or "/")
        validate_full_topic_name(full)
    except (ValueError, InvalidTopicNameException):
        return None
    except TypeError:
        # Half a surrogate pair is no text for pybind11.
        return None
    return full


def by_rosbase(topic: str, node: str, space: str) -> str | None:
    try:
        return resolve_topic(topic, f"{space}/{node}".removeprefix("/"))
    except BackendError as error:
        return None if "\n" not in str(error) else f"more than a line: {error}"


@settings(max_examples=1000)
@given(topics, tokens, spaces)
@example("/" + "a" * (MAX_TOPIC_LENGTH - 1), "n", "")
@example("/" + "a" * MAX_TOPIC_LENGTH, "n", "")
@example("a" * MAX_TOPIC_LENGTH, "n", "")
@example("~", "n", "/a")
@example("{ns}/x", "n", "")
@example("{ns}", "n", "/a")
@example("a{node}1/{namespace}", "n", "/a/b")
def test_a_name_is_taken_and_resolved_as_ros_does(topic: str, node: str, space: str) -> None:
    expected = by_ros(topic, node, space)
    if topic.startswith("~") and topic[1:2] not in ("", "/"):
        # ROS's own rules forbid it (design.ros2.org); rcl overlooks it, and publishes /nodex.
        expected = None
    if "\0" in topic:
        # rclpy cuts a text at a NUL.
        expected = None
    assert by_rosbase(topic, node, space) == expected


@pytest.mark.parametrize("topic", ["a//b", "1abc", "imu/", " ", "~x", "{x}", "ä", "a" * 300])
def test_a_node_of_ros_refuses_a_wrong_name_in_the_same_words(
    backend: Ros2Backend, topic: str
) -> None:
    with pytest.raises(BackendError) as expected:
        resolve_topic(topic, "test_node")
    with pytest.raises(BackendError) as of_publisher:
        backend.create_publisher(String, topic, 10)
    with pytest.raises(BackendError) as of_subscription:
        backend.create_subscription(String, topic, print, 10)
    assert str(of_publisher.value) == str(of_subscription.value) == str(expected.value)


def test_private_names_and_substitutions_are_those_of_the_node(backend: Ros2Backend) -> None:
    for topic in ("~", "~/words", "{node}/words", "/{node}"):
        publisher = backend.create_publisher(String, topic, 10)
        assert publisher.topic == resolve_topic(topic, "test_node")
