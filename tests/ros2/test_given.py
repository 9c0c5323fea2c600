"""What users give a node from outside takes effect, or is named once."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from imu_serial.simulator import PtyDevice
from rosbase import ParameterError, ParameterSpec
from rosbase.messages import String
from rosbase_ros2.backend import Ros2Backend
from rosbase_ros2.qos_overrides import QoSOverrides
from support.command import RunningRosbase, run_rosbase
from support.ros import Client, Open, params_file
from support.waiting import wait_until


def spin(backend: Ros2Backend) -> None:
    """Has the main loop do what waits."""
    while backend.spin_once(0.0):
        pass


def messages(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [record.getMessage() for record in caplog.records]


def test_a_parameter_that_nobody_has_is_named_once_with_the_nearest_one(
    opened: Open, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = params_file(
        tmp_path,
        "driver:\n  ros__parameters:\n    stale_timout: 3.0\n    rate: 7.0\n"
        "    robot: {name: eve}\n",
    )
    backend = opened("--params-file", file, "-p", "baud_rate:=9600")
    for name in ("stale_timeout", "rate", "baudrate"):
        backend.declare_parameter(ParameterSpec(name, 1.0))
    for _ in range(3):
        spin(backend)
    said = "is set from outside, but this node does not declare it"
    assert messages(caplog) == [
        f"parameter baud_rate {said}; did you mean baudrate?",
        f"parameter robot.name {said}",
        f"parameter stale_timout {said}; did you mean stale_timeout?",
    ]
    assert backend.get_parameter("rate").value == 7.0


def test_what_is_declared_or_belongs_to_ros_is_not_named(
    opened: Open, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = params_file(tmp_path, "/**:\n  ros__parameters: {use_sim_time: false, rate: 7.0}\n")
    backend = opened("--params-file", file, "-p", "start_type_description_service:=false")
    backend.declare_parameter(ParameterSpec("rate", 1.0))
    spin(backend)
    assert messages(caplog) == []


def test_a_child_does_not_complain_of_what_its_manager_was_given(
    opened: Open, caplog: pytest.LogCaptureFixture
) -> None:
    spin(opened("-p", "rate:=7", is_child=True))
    assert messages(caplog) == []


@pytest.mark.parametrize(
    "text",
    [
        "imu_driver:\n  ros__parameters: {rate: 7.0}\n",
        "robot:\n  imu_driver:\n    ros__parameters: {rate: 7.0}\n",
        "/robot/driver:\n  ros__parameters: {rate: 7.0}\n",
    ],
)
def test_a_file_that_is_about_another_node_is_named(
    opened: Open, tmp_path: Path, caplog: pytest.LogCaptureFixture, text: str
) -> None:
    file = params_file(tmp_path, text)
    backend = opened("--params-file", file)
    backend.declare_parameter(ParameterSpec("rate", 1.0))
    spin(backend)
    (message,) = messages(caplog)
    assert message.startswith(f"{file} has no parameters for /driver, only for /")
    assert "driver" in message.rpartition("only for ")[2]


@pytest.mark.parametrize(
    "text",
    [
        "driver:\n  ros__parameters: {rate: 7.0}\nother:\n  ros__parameters: {x: 1}\n",
        "/**:\n  ros__parameters: {rate: 7.0}\n",
        "/*:\n  ros__parameters: {rate: 7.0}\n",
        "",
    ],
)
def test_a_file_that_is_about_this_node_too_is_not(
    opened: Open, tmp_path: Path, caplog: pytest.LogCaptureFixture, text: str
) -> None:
    backend = opened("--params-file", params_file(tmp_path, text))
    backend.declare_parameter(ParameterSpec("rate", 1.0))
    spin(backend)
    assert messages(caplog) == []


# Quality of service.


def profile_of(backend: Ros2Backend, topic: str) -> QoSProfile:
    (publisher,) = [p for p in backend.node.publishers if p.topic_name == topic]
    profile: QoSProfile = publisher.qos_profile
    return profile


def test_a_publisher_offers_what_it_is_given(
    opened: Open, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = params_file(
        tmp_path,
        "driver:\n  ros__parameters:\n    qos_overrides:\n      /words:\n        publisher:\n"
        "          reliability: best_effort\n          durability: transient_local\n"
        "          history: keep_all\n          depth: 7\n",
    )
    backend = opened("--params-file", file)
    mine = QoSProfile(depth=3)
    backend.create_publisher(String, "words", mine)
    backend.create_publisher(String, "others", mine)
    backend.create_subscription(String, "words", print, 3)
    profile = profile_of(backend, "/words")
    assert (profile.reliability, profile.durability, profile.history, profile.depth) == (
        ReliabilityPolicy.BEST_EFFORT,
        DurabilityPolicy.TRANSIENT_LOCAL,
        HistoryPolicy.KEEP_ALL,
        7,
    )
    # The profile is the program's, and the other topic's too.
    assert profile_of(backend, "/others") == mine == QoSProfile(depth=3)
    (subscription,) = [
        s for s in backend.node.entities("subscriptions") if s.topic_name == "/words"
    ]
    assert subscription.qos_profile.reliability == ReliabilityPolicy.RELIABLE
    # As with rclpy, a parameter says what counts, and cannot be set.
    name = "qos_overrides./words.publisher.reliability"
    assert backend.node.get_parameter(name).value == "best_effort"
    backend.close()
    assert messages(caplog) == []


def test_a_publisher_that_is_created_again_offers_the_same(opened: Open) -> None:
    backend = opened("-p", "qos_overrides./words.publisher.depth:=7")
    for _ in range(2):
        publisher = backend.create_publisher(String, "words", 3)
        assert publisher.inner.qos_profile.depth == 7  # type: ignore[attr-defined]  # rosbase's own kind of publisher
        backend.destroy_publisher(publisher)


@pytest.mark.parametrize(("override", "kept"), [("depth:=2", 2), ("history:=keep_all", 5)])
def test_a_subscription_keeps_as_many_messages_as_it_is_given(
    opened: Open, override: str, kept: int
) -> None:
    backend = opened("-p", f"qos_overrides./words.subscription.{override}")
    subscription: Any = backend.create_subscription(String, "words", print, 3)
    for number in range(5):
        subscription.deliver(f"{number}")
    assert subscription.dropped == 5 - kept


def test_the_topic_is_the_one_after_remapping(opened: Open) -> None:
    backend = opened("-r", "words:=letters", "-p", "qos_overrides./letters.publisher.depth:=7")
    backend.create_publisher(String, "words", 3)
    assert profile_of(backend, "/letters").depth == 7


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("reliability:=best-effort", "is one of .*best_effort.*, not 'best-effort'"),
        ("durability:=latched", "is one of .*transient_local.*, not 'latched'"),
        ("history:=true", "is one of .*keep_all, not True"),
        ("depth:=0", "is a whole number from 1 up, not 0"),
        ("depth:='5'", "is a whole number from 1 up, not '5'"),
        ("depth:=5.0", "is a whole number from 1 up, not 5.0"),
    ],
)
def test_a_value_that_is_none_is_an_error_at_once(opened: Open, override: str, said: str) -> None:
    with pytest.raises(ParameterError, match=f"^parameter qos_overrides./words.*{said}") as caught:
        opened("-p", f"qos_overrides./words.publisher.{override}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("/words.publisher.reliabilty", "did you mean reliability?"),
        ("/words.publisher.deadline", "the policy is one of depth, durability, history, rel"),
        ("/words.publishers.depth", "'publishers' is not publisher or subscription; did you"),
        ("/words.publisher_mine.depth", "is not publisher or subscription"),
        ("words.publisher.depth", "the topic is given by its full name; did you mean /words?"),
        ("/words.publisher", "the policy is one of"),
        ("/words.depth", "'depth' is not publisher or subscription"),
        ("/words.publisher.depth.more", "the policy is one of"),
    ],
)
def test_a_name_that_can_mean_nothing_is_named_at_once(
    opened: Open, caplog: pytest.LogCaptureFixture, name: str, said: str
) -> None:
    opened("-p", f"qos_overrides.{name}:=5")
    (message,) = messages(caplog)
    assert message.startswith(f"parameter qos_overrides.{name} has no effect: ")
    assert said in message


def test_a_topic_that_is_nearly_one_is_named_when_that_one_is_created(
    opened: Open, caplog: pytest.LogCaptureFixture
) -> None:
    backend = opened(
        *("-p", "qos_overrides./imu/dat.publisher.depth:=7"),
        *("-p", "qos_overrides./imu/data_raw.publisher.depth:=7"),
    )
    backend.create_publisher(String, "imu/data", 3)
    backend.create_publisher(String, "imu/data_raw", 3)
    for _ in range(3):
        spin(backend)
    assert messages(caplog) == [
        "parameter qos_overrides./imu/dat.publisher.depth has no effect:"
        " there is no publisher of /imu/dat; did you mean /imu/data?"
    ]


def test_a_topic_that_was_never_created_is_named_at_the_end(
    opened: Open, caplog: pytest.LogCaptureFixture
) -> None:
    backend = opened("-p", "qos_overrides./words.subscription.depth:=7")
    backend.create_publisher(String, "words", 3)
    spin(backend)
    assert messages(caplog) == []
    backend.close()
    assert messages(caplog) == [
        "parameter qos_overrides./words.subscription.depth has no effect:"
        " there was no subscription of /words"
    ]


def test_overrides_cost_nothing_where_there_are_none() -> None:
    overrides = QoSOverrides({"rate": 1.0}, print)
    assert overrides.options("/words", "publisher") is None
    assert not overrides.is_unused


# The reader.


@pytest.fixture
def device() -> Iterator[PtyDevice]:
    device = PtyDevice()
    yield device
    device.close()


def test_the_reader_heeds_a_file_of_ros_and_names_what_it_does_not_know(
    device: PtyDevice, tmp_path: Path, context: Any
) -> None:
    file = params_file(
        tmp_path,
        "lifecycle_manager:\n  ros__parameters:\n"
        f"    device_path: {device.parameters['device_path']}\n"
        "    stale_timout: 3.0\n"
        "    qos_overrides./imu/data.publisher.reliability: best_effort\n"
        "    qos_overrides./imu/data.publisher.depth: 5\n",
    )
    client = Client(context, "lifecycle_manager")
    try:
        with RunningRosbase(
            "imu", "--backend", "ros2", "--ros-args", "--params-file", file
        ) as reader:
            reader.waits_for("opened")
            reader.waits_for(
                "parameter stale_timout is set from outside, but this node does not declare it;"
                " did you mean stale_timeout?"
            )

            def offered() -> list[Any]:
                found = client.node.get_publishers_info_by_topic("/imu/data")
                return [info.qos_profile.reliability for info in found]

            wait_until(lambda: offered() == [ReliabilityPolicy.BEST_EFFORT], "the publisher")
            assert reader.end(2) == 0
    finally:
        client.destroy()
    assert reader.err.count("stale_timout") == 1
    assert "has no effect" not in reader.err


def test_a_bad_override_is_one_line_and_status_2_before_the_device_is_opened(
    device: PtyDevice,
) -> None:
    path = device.parameters["device_path"]
    done = run_rosbase(
        "imu", "--backend", "ros2", "-p", f"device_path:={path}",
        "--ros-args", "-p", "qos_overrides./imu/data.publisher.reliability:=best-effort",
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "best_effort" in done.stderr


@pytest.mark.parametrize("namespace", ["a//b", "1abc", "{x}"])
def test_a_bad_topic_namespace_is_one_line_and_status_2_before_the_device_is_opened(
    device: PtyDevice, namespace: str
) -> None:
    path = device.parameters["device_path"]
    done = run_rosbase(
        "imu", "--backend", "ros2", "-p", f"device_path:={path}",
        "-p", f"topic_namespace:={namespace}",
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("rosbase: parameter topic_namespace: ")


def test_an_unknown_parameter_of_the_command_is_an_error_with_a_hint() -> None:
    done = run_rosbase("imu", "--backend", "ros2", "-p", "stale_timout:=3.0")
    assert (done.returncode, done.stderr) == (
        2,
        "rosbase: unknown parameter 'stale_timout'; did you mean stale_timeout?\n",
    )
