"""Recordings as others read them: rosbags, mcap with ROS 2, and rclpy if it is installed."""

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

__all__ = ["READERS", "Read"]

HAS_RCLPY = find_spec("rclpy") is not None

Read = list[tuple[str, int, Any]]
"""Topic, date and message, in the order of the file."""


def by_mcap(path: Path) -> Read:
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [
            (channel.topic, message.log_time, read)
            for _, channel, message, read in reader.iter_decoded_messages()
        ]


def by_rosbags(path: Path) -> Read:
    with AnyReader([path]) as reader:
        return [
            (connection.topic, stamp, reader.deserialize(data, connection.msgtype))
            for connection, stamp, data in reader.messages()
        ]


def by_rclpy(path: Path) -> Read:
    """The messages, each read by rclpy with the class of its name, as `ros2 bag` does."""
    with path.open("rb") as stream:
        return [
            (channel.topic, message.log_time, _deserialized(message.data, schema))
            for schema, channel, message in make_reader(stream).iter_messages()
        ]


def _deserialized(data: bytes, schema: Any) -> Any:
    from rclpy.serialization import deserialize_message

    package, kind, name = schema.name.split("/")
    return deserialize_message(data, getattr(import_module(f"{package}.{kind}"), name))


READERS = [by_mcap, by_rosbags, *([by_rclpy] if HAS_RCLPY else [])]
