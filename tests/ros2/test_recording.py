"""Recordings of programs on ROS: rosbase's own topics, the program's, and those of others."""

from pathlib import Path
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import Vector3 as RosVector3
from rcl_interfaces.msg import Log as RosLog
from rcl_interfaces.msg import ParameterEvent as RosParameterEvent
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Imu as RosImu

from rosbase import BaseManager, BaseNode, LifecycleNode
from rosbase.messages import Imu, Vector3
from rosbase_mcap.reading import messages

CLASSES = {
    "rcl_interfaces/msg/Log": RosLog,
    "rcl_interfaces/msg/ParameterEvent": RosParameterEvent,
    "sensor_msgs/msg/Imu": RosImu,
    "geometry_msgs/msg/Vector3": RosVector3,
}


class Talker(BaseNode):
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.declare_parameter("speed", 1.5)
        self.imu = self.create_publisher(Imu, "imu/data", 10)
        self.imu.publish(Imu(angular_velocity=Vector3(-1.0)))
        self.heard: list[Vector3] = []
        self.create_subscription(Vector3, "wind", self.heard.append, 10)
        node: Any = self.manager.backend.node  # type: ignore[union-attr]  # it has a manager
        self.own = node.create_publisher(RosVector3, "own", 10)
        self.own.publish(RosVector3(x=3.0))


class Robot(BaseManager):
    outside: Any = None

    def main_loop(self) -> None:
        talker = self.node(Talker)
        talker.imu.publish(Imu(angular_velocity=Vector3(float(len(talker.heard)))))
        self.outside.publish(RosVector3(x=2.0))
        if talker.heard:
            self.logger.warning("that was all")
            self.request_stop()


def test_a_program_on_ros_is_recorded(
    tmp_path: Path, context: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.mcap"
    node: Any = rclpy.create_node("outside", context=context)
    try:
        robot = Robot(
            "robot",
            {"talker": Talker, "arm": LifecycleNode},
            backend="ros2",
            node_freq_hz=20,
            record=path,
        )
        robot.outside = node.create_publisher(RosVector3, "wind", 10)
        robot.start_main_loop_timer()
    finally:
        node.destroy_node()
    with path.open("rb") as stream:
        entries = list(messages(stream))
    found: dict[str, list[Any]] = {}
    for entry in entries:
        assert entry.schema is not None
        # rclpy reads what it knows; it has each of them from the class of its name.
        if entry.schema.name in CLASSES:
            read = deserialize_message(bytes(entry.message.data), CLASSES[entry.schema.name])
            found.setdefault(entry.channel.topic, []).append(read)
    rates = [imu.angular_velocity.x for imu in found["/imu/data"]]
    assert rates[:2] == [-1.0, 0.0]
    assert [vector.x for vector in found["/own"]] == [3.0]
    assert [vector.x for vector in found["/wind"]][:1] == [2.0]
    names = {new.name for event in found["/parameter_events"] for new in event.new_parameters}
    assert "talker.speed" in names
    assert [line.msg for line in found["/rosout"]].count("that was all") == 1
    transitions = [entry for entry in entries if entry.channel.topic == "/arm/transition_event"]
    assert transitions
    assert transitions[0].schema is not None
    assert transitions[0].schema.name == "lifecycle_msgs/msg/TransitionEvent"
