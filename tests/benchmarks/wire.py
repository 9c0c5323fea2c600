"""Messages as bytes beside rclpy and rosbags, and large ones beside one copy of their data.

`nox -s bench -- wire` runs it and prints two tables. The rows take turns, and the cheapest of
their turns counts, because machines are noisy. rclpy's figures begin with a message of ROS, and
those of rosbags with one of its own.

The limits: an Imu is written in 3 us and read in 6. A large message becomes bytes in the time of
one copy of its data, and is published to a subscriber in 20 us whatever its size.
"""

import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

from benchmarks.rig.turns import take_turns
from rosbase.contracts.backend import BackendOptions
from rosbase.local import Bus, LocalBackend
from rosbase.messages import Header, Image, Imu, PointCloud2, Quaternion, Time, Vector3
from rosbase.wire import reader, writer
from rosbase.wire.description import describe
from support.ros_messages import as_ros

TURNS = 15
LIMITS_US = {"write": 3.0, "read": 6.0}
SMALL, LARGE = 3_000, 20

IMU = Imu(
    Header(Time(1_700_000_000, 5), "imu_link"),
    Quaternion(0.1, 0.2, 0.3, 0.9),
    angular_velocity=Vector3(1.0, 2.0, 3.0),
    linear_acceleration=Vector3(0.0, 0.1, 9.8),
)


def per_call_us(call: Callable[[], object], calls: int) -> float:
    """Microseconds of CPU for each call."""
    begin_ns = time.thread_time_ns()
    for _ in range(calls):
        call()
    return (time.thread_time_ns() - begin_ns) / calls / 1e3


def imu_rows() -> dict[str, Callable[[], object]]:
    """What is measured of an Imu."""
    write, read = writer(Imu), reader(Imu)
    data = write(IMU)
    rows = {"rosbase write": lambda: write(IMU), "rosbase read": lambda: read(data)}
    try:
        ros: Any = import_module("rclpy.serialization")
        theirs = as_ros(IMU, describe(Imu))
        ros_type = type(theirs)
        rows["rclpy write"] = lambda: ros.serialize_message(theirs)
        rows["rclpy read"] = lambda: ros.deserialize_message(data, ros_type)
    except ImportError:
        print("without rclpy")
    try:
        rosbags: Any = import_module("rosbags.typesys")
        store = rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY)
        name = "sensor_msgs/msg/Imu"
        bag_imu = store.deserialize_cdr(data, name)
        rows["rosbags write"] = lambda: store.serialize_cdr(bag_imu, name)
        rows["rosbags read"] = lambda: store.deserialize_cdr(data, name)
    except ImportError:
        print("without rosbags")
    return rows


def large_messages() -> dict[str, Any]:
    """Messages of several megabytes, and one small one of the same class."""
    pixels, points = bytes(range(256)) * (1920 * 1080 * 3 // 256), bytes(5_000_000)
    return {
        "Image 64 x 64": Image(height=64, width=64, step=192, data=memoryview(pixels)[: 64 * 192]),
        "Image 1920 x 1080": Image(height=1080, width=1920, step=5760, data=pixels),
        "PointCloud2 5 MB": PointCloud2(width=312_500, point_step=16, data=memoryview(points)),
    }


def large_rows(message: Any) -> dict[str, Callable[[], object]]:
    """What is measured of a large message."""
    kind = type(message)
    write, read = writer(kind), reader(kind)
    data, source = write(message), bytearray(message.data)
    backend = LocalBackend(BackendOptions("bench"), Bus())
    got: list[Any] = []
    backend.create_subscription(kind, "topic", got.append, 1)
    publish = backend.create_publisher(kind, "topic", 1).publish

    def send() -> None:
        publish(message)
        backend.spin_once(0.0)
        assert got.pop() is message

    return {
        "one copy": lambda: bytes(source),
        "write": lambda: write(message),
        "read": lambda: read(data),
        "publish to callback": send,
    }


def cheapest(rows: dict[str, Callable[[], object]], calls: int) -> dict[str, float]:
    """Microseconds of CPU for each row, in its cheapest turn."""
    turns = take_turns(lambda name: per_call_us(rows[name], calls), rows, TURNS)
    return {name: min(figures) for name, figures in turns.items()}


def main() -> None:
    """Prints the tables, and how many limits do not hold."""
    missed = 0
    print(f"{'Imu':24}{'us':>8}{'limit':>8}")
    for name, us in cheapest(imu_rows(), SMALL).items():
        library, _, what = name.partition(" ")
        limit = LIMITS_US[what] if library == "rosbase" else None
        missed += limit is not None and us > limit
        print(f"{name:24}{us:8.2f}{limit or '':>8}")
    print(f"\n{'':20}{'one copy':>12}{'write':>10}{'of copy':>9}{'read':>8}{'publish':>9}   us")
    for name, message in large_messages().items():
        us_of = cheapest(large_rows(message), LARGE)
        copy, write, read, publish = us_of.values()
        missed += publish > 20.0
        print(f"{name:20}{copy:12.1f}{write:10.1f}{write / copy:9.2f}{read:8.1f}{publish:9.1f}")
    print(f"\n{missed} of the limits missed" if missed else "\nall within the limits")


if __name__ == "__main__":
    main()
