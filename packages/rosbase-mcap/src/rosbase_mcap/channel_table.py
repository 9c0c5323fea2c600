"""The channels of a recording, with the same numbers in each of its files."""

import threading
from collections.abc import Mapping

from rosbase_mcap.errors import McapError
from rosbase_mcap.records import Channel, Schema

__all__ = ["CDR", "LATCHED", "QOS", "ROS2MSG", "ChannelTable"]

CDR, ROS2MSG = "cdr", "ros2msg"
"""Encoding of messages and of schemas that `ros2 bag` plays. One for all: it refuses a mixture."""
QOS = "offered_qos_profiles"
"""Metadata of a channel: profiles of the publishers, as YAML."""
LATCHED = "rosbase_latched"
"""Metadata of a channel whose publishers keep messages for those who come later."""
_MOST = 65_535


class ChannelTable:
    """Gives out numbers. Any thread asks; an entry never changes."""

    def __init__(self) -> None:
        self._channels: list[Channel] = []
        self._schemas: list[Schema] = []
        self._numbers: dict[tuple[str, str], int] = {}
        self._lock = threading.RLock()

    def add(self, topic: str, type_name: str, schema: str, metadata: Mapping[str, str]) -> int:
        """Return the number of the channel of a topic, which is new if the topic or the type is.

        Args:
            topic: Full name of the topic.
            type_name: Type of the messages, such as `sensor_msgs/msg/Imu`.
            schema: Its schema, of the format `ros2msg`.
            metadata: Of a new channel.

        Raises:
            McapError: A file has no room for more channels.
        """
        with self._lock:
            number = self._numbers.get((topic, type_name))
            if number is None:
                number = len(self._channels)
                if number > _MOST:
                    raise McapError(f"a recording has at most {_MOST} channels")
                schema_id = self._schema_id(type_name, schema.encode())
                self._channels.append(Channel(number, schema_id, topic, CDR, dict(metadata)))
                self._numbers[topic, type_name] = number
            return number

    def channel(self, number: int) -> Channel:
        """Return a channel."""
        return self._channels[number]

    def schema(self, number: int) -> Schema:
        """Return the schema of a channel."""
        return self._schemas[self._channels[number].schema_id - 1]

    def is_latched(self, number: int) -> bool:
        """Return whether messages of a channel are kept for those who come later."""
        return LATCHED in self._channels[number].metadata

    def _schema_id(self, name: str, data: bytes) -> int:
        for schema in self._schemas:
            if schema.name == name and schema.data == data:
                return schema.id
        self._schemas.append(Schema(len(self._schemas) + 1, name, ROS2MSG, data))
        return len(self._schemas)
