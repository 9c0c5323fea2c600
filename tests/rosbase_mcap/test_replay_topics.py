"""Replays of topics: messages of a bag in place of those of the program, in virtual time."""

from pathlib import Path
from typing import Any

import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from rosbase import BaseManager, BaseNode, ConfigurationError, DurabilityPolicy, QoSProfile
from rosbase.contracts.message_format import message_format
from rosbase.messages import Header, Imu, Time, Vector3
from rosbase.messages.rcl_interfaces import Log
from rosbase_mcap import Replay, replay
from rosbase_mcap.channel_table import LATCHED, ChannelTable
from rosbase_mcap.file_sink import declare
from rosbase_mcap.file_writer import FileWriter
from support.bag_reading import with_reason

S = 1_000_000_000
START = 1_700_000_000 * S


def bag(path: Path, *lines: tuple[str, float, Any], latched: str = "") -> Path:
    """A file of messages, each with its topic and its time in seconds."""
    pieces, table = list[bytes | memoryview](), ChannelTable()
    writer = FileWriter(pieces.append)
    for topic, second, message in lines:
        form = message_format(type(message))
        metadata = {LATCHED: "true"} if topic == latched else {}
        number = table.add(topic, form.type_name, form.schema, metadata)
        stamp_ns = START + int(second * S)
        declare(writer, table, [number])
        writer.add(number, 0, stamp_ns, stamp_ns, form.encode(message))
    writer.finish()
    path.write_bytes(b"".join(pieces))
    return path


def imu(second: int) -> tuple[str, float, Imu]:
    header = Header(Time(second, 0), "imu_link")
    return "/imu/data", float(second), Imu(header, angular_velocity=Vector3(float(second)))


class Reader(BaseNode):
    """Publishes what would come from a device."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        publisher = self.create_publisher(Imu, "imu/data", 10)
        self.create_timer(0.5, lambda: publisher.publish(Imu(Header(Time(), "device"))))


class Listener(BaseNode):
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.heard = self.create_publisher(Header, "heard", 10)
        self.create_subscription(Imu, "imu/data", self.on_imu, 10)

    def on_imu(self, message: Imu) -> None:
        self.heard.publish(Header(self.get_clock().now(), message.header.frame_id))


class Robot(BaseManager):
    def __init__(self) -> None:
        super().__init__("robot", {"reader": Reader, "listener": Listener}, node_freq_hz=10)


def stamps(run: Replay) -> list[float]:
    return [stamp for stamp, _ in run.stamped("heard")]


def test_a_program_gets_the_messages_at_their_times_in_place_of_its_own(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    path = bag(tmp_path / "run.mcap", *[imu(second) for second in range(1, 5)])
    run = replay(path, Robot)
    dates = [(header.stamp.sec, header.frame_id) for header in run.topic("heard")]
    # The start of a bag is its first message.
    assert dates == [(1_700_000_000 + second, "imu_link") for second in range(1, 5)]
    assert stamps(run) == [0.0, 1.0, 2.0, 3.0]
    assert [message.angular_velocity.x for message in run.topic("/imu/data")] == [1, 2, 3, 4]
    assert run.topics == ["/heard", "/imu/data", "/rosout"]
    assert "/imu/data comes from the recording" in "\n".join(line.msg for line in run.log)
    again = replay(path, Robot)
    assert (again.sha256, again.difference, again.cut_short) == (run.sha256, "", "")


def test_only_the_topics_that_were_chosen_come_from_the_file(tmp_path: Path) -> None:
    recorded = Header(Time(), "recorded")
    path = bag(tmp_path / "run.mcap", imu(1), ("/heard", 2.5, recorded), ("/other", 3.0, recorded))
    run = replay(path, Robot, topics=["heard"])
    # The reader's own messages, and one of the file in place of those of the listener.
    assert [message.frame_id for message in run.topic("heard")] == ["recorded"]
    assert [message.header.frame_id for message in run.topic("imu/data")] == ["device"] * 3


def test_a_topic_that_is_not_in_the_file_is_refused_with_those_that_are(tmp_path: Path) -> None:
    path = bag(tmp_path / "run.mcap", imu(1))
    with pytest.raises(
        ConfigurationError, match="no topic /imu in this recording; there are: /imu"
    ):
        replay(path, Robot, topics=["imu"])


def test_time_does_not_go_back_with_the_times_of_a_file(tmp_path: Path) -> None:
    path = bag(tmp_path / "run.mcap", imu(1), imu(3), imu(2), imu(4))
    assert stamps(replay(path, Robot)) == [0.0, 2.0, 2.0, 3.0]


def test_messages_of_another_type_are_named_and_left_out(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = bag(tmp_path / "run.mcap", ("/imu/data", 1.0, Header()), ("/imu/data", 3.0, Header()))
    run = replay(path, Robot)
    assert stamps(run) == []
    lines = [line.msg for line in run.log if line.level >= Log.WARN]
    assert lines == [
        "/imu/data is not replayed: the program takes sensor_msgs/msg/Imu, "
        "the recording has std_msgs/msg/Header"
    ]


class Mounted(BaseNode):
    """Subscribes late, as a node does that comes up later."""

    def listen(self) -> None:
        profile = QoSProfile(5, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        got = self.create_publisher(Header, "got", 10)
        self.create_subscription(Header, "mounted", got.publish, profile)


class Late(BaseManager):
    def __init__(self) -> None:
        super().__init__("late", {"mounted": Mounted}, node_freq_hz=10)

    def update_timestamp(self) -> None:
        super().update_timestamp()
        if self.timestamp == 20:
            self.node(Mounted).listen()


def test_latched_messages_reach_nodes_that_come_later(tmp_path: Path) -> None:
    frames = [("/mounted", float(second), Header(Time(), f"f{second}")) for second in (1, 2, 6)]
    path = bag(tmp_path / "run.mcap", *frames, latched="/mounted")
    for topics in (None, ["/mounted"]):
        run = replay(path, Late, topics=topics)
        assert [header.frame_id for header in run.topic("got")] == ["f1", "f2", "f6"]


@pytest.mark.parametrize("plugin", [with_reason(plugin, plugin.name) for plugin in StoragePlugin])
def test_a_bag_that_rosbags_wrote_drives_an_unchanged_program(
    plugin: StoragePlugin, tmp_path: Path
) -> None:
    store, name = get_typestore(Stores.ROS2_HUMBLE), "sensor_msgs/msg/Imu"
    with Writer(tmp_path / "bag", version=9, storage_plugin=plugin) as writer:
        connection = writer.add_connection("/imu/data", name, typestore=store)
        for second in range(1, 5):
            data = message_format(Imu).encode(imu(second)[2])
            writer.write(connection, START + second * S, data)
    run = replay(tmp_path / "bag", Robot)
    assert stamps(run) == [0.0, 1.0, 2.0, 3.0]
    assert [message.angular_velocity.x for message in run.topic("/imu/data")] == [1, 2, 3, 4]
