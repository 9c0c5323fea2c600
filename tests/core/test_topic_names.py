"""Topic names and frames, checked before anything is opened; beside rclpy in tests/ros2."""

import pytest

from rosbase import BackendError, ParameterError, resolve_topic
from rosbase.contracts.names import MAX_TOPIC_LENGTH
from rosbase.imu.names import check_names
from rosbase.lifecycle import CallbackReturn
from rosbase.messages import String
from support.reader_rig import Rig

LONGEST = "/" + "a" * (MAX_TOPIC_LENGTH - 1)
GOOD = {
    "imu/data": "/front/imu/data",
    "/imu/data": "/imu/data",
    "~": "/front/driver",
    "~/status": "/front/driver/status",
    "{node}/status": "/front/driver/status",
    "{ns}/status": "/front/status",
    "{namespace}/status": "/front/status",
    "a{node}_{node}": "/front/adriver_driver",
    "_": "/front/_",
    "__a__": "/front/__a__",
    "A1": "/front/A1",
    LONGEST: LONGEST,
}

BAD = {
    "": "it is empty",
    "/": "must be followed by a name",
    "a/": "must be followed by a name",
    "a//b": "must be followed by a name",
    "//a": "must be followed by a name",
    "1abc": "'1abc' begins with a digit",
    "a/2": "'2' begins with a digit",
    " ": "it has ' '",
    "a b": "it has ' '",
    "a\n": r"it has '\\n'",
    "a\0": r"it has '\\x00'",
    "ä": "it has 'ä'",
    "a.b": r"it has '\.'",
    "a-b": "it has '-'",
    "\uff41": "it has",
    "~x": "~ is allowed at the start only",
    "a/~": "~ is allowed at the start only",
    "~~": "~ is allowed at the start only",
    "{x}": "is one of {node}, {ns} and {namespace}",
    "{node": "is one of",
    "a}": "is one of",
    "{}": "is one of",
    "/" + "a" * MAX_TOPIC_LENGTH: "has 248 characters, and 247 are allowed",
}


@pytest.mark.parametrize(("topic", "full"), GOOD.items())
def test_a_name_is_resolved_as_ros_does(topic: str, full: str) -> None:
    assert resolve_topic(topic, "front/driver") == full


@pytest.mark.parametrize(("topic", "why"), BAD.items(), ids=map(ascii, BAD))
def test_what_is_no_name_is_one_line_that_says_why(topic: str, why: str) -> None:
    with pytest.raises(BackendError, match=f"is not a topic name: .*{why}") as caught:
        resolve_topic(topic, "driver")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 200


def test_what_a_node_makes_of_a_name_counts_too() -> None:
    with pytest.raises(BackendError, match="for this node it is '/not a name/x'"):
        resolve_topic("~/x", "not a name")
    with pytest.raises(BackendError, match="characters, and 247 are allowed"):
        resolve_topic("a" * 200, "b" * 60 + "/driver")
    assert resolve_topic("/x", "not a name") == "/x"


BAD_NAMESPACES = ["a//b", "1abc", "imu/", " ", "~x", "{x}", "a b", "ä", "a\nb", "/", "a" * 300]


@pytest.mark.parametrize("namespace", BAD_NAMESPACES, ids=ascii)
def test_a_reader_with_a_bad_namespace_is_refused_when_it_is_made(namespace: str) -> None:
    with pytest.raises(ParameterError, match=r"^parameter topic_namespace: ") as caught:
        Rig(topic_namespace=namespace)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("namespace", ["imu", "/robot/imu", "~", "~/imu", "{node}", "", "_1"])
def test_any_other_is_as_good_as_imu(namespace: str) -> None:
    check_names(namespace, "imu_link", "lifecycle_manager")


def test_one_that_only_this_node_makes_too_long_is_refused_too() -> None:
    check_names("a" * 230, "imu_link", "driver")
    with pytest.raises(ParameterError, match="topic_namespace"):
        check_names("a" * 230, "imu_link", "a_robot/driver")


@pytest.mark.parametrize(
    ("frame_id", "why"),
    [
        ("", "is empty, and tf2"),
        ("/imu_link", "starts with /, and tf2 takes no such frame; did you mean imu_link?"),
        ("\udcff", "is not UTF-8"),
    ],
)
def test_a_frame_that_ros_takes_nowhere_is_refused(frame_id: str, why: str) -> None:
    with pytest.raises(ParameterError, match=rf"^parameter frame_id: .*{why}"):
        Rig(frame_id=frame_id)


@pytest.mark.parametrize("frame_id", ["imu_link", "front/imu_link", "gerät 2", "x" * 5000])
def test_any_other_frame_is_taken(frame_id: str) -> None:
    Rig(frame_id=frame_id).backend.close()


def test_a_topic_that_carries_something_else_fails_configure_and_gives_the_device_back() -> None:
    rig = Rig(topic_namespace="robot")
    taken = rig.backend.create_publisher(String, "robot/mag", 10)
    assert rig.reader.trigger_configure() is CallbackReturn.FAILURE
    assert "/robot/mag" in str(rig.reader.last_error)
    assert rig.transport.calls == ["open", "close"]
    rig.backend.destroy_publisher(taken)
    assert rig.reader.trigger_configure() is CallbackReturn.SUCCESS
    rig.backend.close()
