"""Replays of topics: messages of a bag in place of those of the program, in virtual time."""

from pathlib import Path
from typing import Any

import pytest

from rosbase import BaseHandlers, BaseManager, BaseNode, ConfigurationError
from rosbase.contracts.message_format import message_format
from rosbase.messages import Header, Imu, Time, Vector3
from rosbase_mcap import replay
from rosbase_mcap.channel_table import LATCHED, ChannelTable
from rosbase_mcap.file_sink import write_items
from rosbase_mcap.file_writer import FileWriter

S = 1_000_000_000
START = 1_700_000_000 * S


def bag(path: Path, *lines: tuple[str, float, Any], latched: str = "") -> Path:
    """A file of messages, each with its topic and its time in seconds."""
    pieces, table = list[bytes](), ChannelTable()
    writer = FileWriter(pieces.append)
    for topic, second, message in lines:
        form = message_format(type(message))
        metadata = {LATCHED: "true"} if topic == latched else {}
        number = table.add(topic, form.type_name, form.schema, metadata)
        stamp_ns = START + int(second * S)
        write_items(writer, table, [(number, 0, stamp_ns, stamp_ns, form.encode(message))])
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


def test_a_program_gets_the_messages_at_their_times(tmp_path: Path) -> None:
    path = bag(tmp_path / "run.mcap", *[imu(second) for second in range(1, 5)])
    run = replay(path, Robot)
    dates = [(header.stamp.sec, header.frame_id) for header in run.topic("heard")]
    # The start of a bag is its first message.
    assert dates == [(1_700_000_000 + second, "imu_link") for second in range(1, 5)]
    assert [stamp for stamp, _ in run.stamped("heard")] == [0.0, 1.0, 2.0, 3.0]
    assert [message.angular_velocity.x for message in run.topic("/imu/data")] == [1, 2, 3, 4]
    assert "/imu/data comes from the recording" in "\n".join(line.msg for line in run.log)
    again = replay(path, Robot)
    assert again.sha256 == run.sha256
