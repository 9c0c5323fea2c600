"""A program of rclpy that publishes an Imu on four topics, and its recording by rosbags.

`publish PATH` publishes, and writes what it publishes to PATH, unless that is empty.
`record PATH` subscribes from another process, as `ros2 bag record` does, and ends with SIGINT.
Each prints its CPU in nanoseconds, and how many messages it has published or written.
"""

import sys
import time
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import Imu

TOPICS = [f"/imu_{number}/data" for number in range(4)]
TYPE = "sensor_msgs/msg/Imu"


def opened(path: str) -> tuple[Any, list[Any]]:
    """A bag of MCAP, and its connections."""
    writer = Writer(Path(path), version=9, storage_plugin=StoragePlugin.MCAP)
    writer.open()
    store = get_typestore(Stores.ROS2_JAZZY)
    return writer, [writer.add_connection(topic, TYPE, typestore=store) for topic in TOPICS]


def publish(path: str, seconds: str, batch: str) -> None:
    rclpy.init()
    node: Any = rclpy.create_node("talker")
    publishers = [node.create_publisher(Imu, topic, 1000) for topic in TOPICS]
    writer, connections = opened(path) if path else (None, [])
    sent, message = 0, Imu()
    message.angular_velocity.x = 1.0
    # A subscriber may need a while.
    time.sleep(1.0)
    before_ns, start_ns = time.process_time_ns(), time.monotonic_ns()
    for turn in range(int(seconds) * 100):
        for number in range(int(batch)):
            publishers[number % 4].publish(message)
            if writer is not None:
                data = serialize_message(message)
                writer.write(connections[number % 4], time.time_ns(), data)
        sent += int(batch)
        left_ns = start_ns + (turn + 1) * 10_000_000 - time.monotonic_ns()
        time.sleep(max(0, left_ns) / 1e9)
    if writer is not None:
        writer.close()
    print(time.process_time_ns() - before_ns, sent, flush=True)
    rclpy.shutdown()


def record(path: str) -> None:
    rclpy.init()
    node: Any = rclpy.create_node("recorder")
    writer, connections = opened(path)
    written = 0

    def writing(connection: Any) -> Any:
        def write(data: bytes) -> None:
            nonlocal written
            writer.write(connection, time.time_ns(), data)
            written += 1

        return write

    for topic, connection in zip(TOPICS, connections, strict=True):
        node.create_subscription(Imu, topic, writing(connection), 1000, raw=True)
    executor: Any = EventsExecutor()
    executor.add_node(node)
    before_ns = time.process_time_ns()
    print("ready", flush=True)
    try:
        while rclpy.ok():
            executor.spin_once(timeout_sec=0.1)
    except (ExternalShutdownException, KeyboardInterrupt):
        pass
    writer.close()
    print(time.process_time_ns() - before_ns, written, flush=True)


if __name__ == "__main__":
    roles: dict[str, Any] = {"publish": publish, "record": record}
    roles[sys.argv[1]](*sys.argv[2:])
