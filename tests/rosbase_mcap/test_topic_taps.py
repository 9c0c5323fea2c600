"""Topics of a program, heard from within."""

from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest

from rosbase import (
    Backend,
    DurabilityPolicy,
    LifecycleNode,
    ParameterSpec,
    QoSProfile,
    make_logger,
)
from rosbase.messages import Imu, Vector3
from rosbase.messages.rcl_interfaces import Log
from rosbase.testing import virtual_backend
from rosbase.wire import deserialize
from rosbase_mcap.channel_table import LATCHED, QOS, ChannelTable
from rosbase_mcap.file_sink import FileSink
from rosbase_mcap.log_channel import LOG_TOPIC, LogChannel
from rosbase_mcap.reading import Entry, messages
from rosbase_mcap.recorder import Recorder
from rosbase_mcap.topic_taps import TopicTaps

LATCHING = QoSProfile(3, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Recording:
    """A backend that is recorded."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.backend: Backend = virtual_backend()
        table, logger = ChannelTable(), make_logger("test")
        self.recorder = Recorder(FileSink(path, table, {}), table, logger)
        self.taps = TopicTaps(self.backend, self.recorder, logger)

    def entries(self) -> list[Entry]:
        """Ends the recording, and returns what is in it."""
        self.taps.close()
        self.recorder.start()
        self.recorder.stop()
        return list(messages(BytesIO(self.path.read_bytes())))


@pytest.fixture
def recording(tmp_path: Path) -> Iterator[Recording]:
    made = Recording(tmp_path / "run.mcap")
    yield made
    made.recorder.stop()
    made.backend.close()


def test_messages_are_recorded_as_cdr_with_their_schema_and_profile(recording: Recording) -> None:
    publisher = recording.backend.create_publisher(Imu, "imu/data", LATCHING)
    recording.taps.begin()
    publisher.publish(Imu(angular_velocity=Vector3(1.0, 2.0, 3.0)))
    [entry] = recording.entries()
    assert entry.channel.topic == "/imu/data"
    assert entry.channel.message_encoding == "cdr"
    assert "durability: 1" in entry.channel.metadata[QOS]
    assert LATCHED in entry.channel.metadata
    assert entry.schema is not None
    assert (entry.schema.name, entry.schema.encoding) == ("sensor_msgs/msg/Imu", "ros2msg")
    assert deserialize(entry.message.data, Imu).angular_velocity == Vector3(1.0, 2.0, 3.0)


def test_kept_messages_are_recorded_once(recording: Recording) -> None:
    publisher = recording.backend.create_publisher(Vector3, "point", LATCHING)
    publisher.publish(Vector3(1.0))
    recording.taps.begin()
    recording.taps.begin()
    publisher.publish(Vector3(2.0))
    found = [deserialize(entry.message.data, Vector3).x for entry in recording.entries()]
    assert found == [1.0, 2.0]


def test_topics_that_come_later_are_found(recording: Recording) -> None:
    recording.taps.begin()
    publisher = recording.backend.create_publisher(Vector3, "point", 10)
    recording.taps.begin()
    publisher.publish(Vector3(2.0))
    assert [entry.channel.topic for entry in recording.entries()] == ["/point"]


def test_a_class_without_a_schema_is_left_out_and_named_once(
    recording: Recording, caplog: pytest.LogCaptureFixture
) -> None:
    class Own:
        pass

    publisher: Any = recording.backend.create_publisher(Own, "own", 10)
    recording.taps.begin()
    recording.taps.begin()
    publisher.publish(Own())
    assert recording.entries() == []
    assert caplog.text.count("/own is not recorded") == 1


def test_parameters_are_recorded_when_they_change(recording: Recording) -> None:
    recording.taps.begin()
    recording.backend.declare_parameter(ParameterSpec("speed", 1.5))
    entries = recording.entries()
    assert {entry.channel.topic for entry in entries} == {"/parameter_events"}
    [schema] = {entry.schema for entry in entries}
    assert schema is not None
    assert schema.name == "rcl_interfaces/msg/ParameterEvent"


def test_transitions_of_lifecycle_nodes_are_recorded(recording: Recording) -> None:
    node = LifecycleNode(None, name="arm", backend=recording.backend)
    recording.taps.begin()
    node.trigger_configure()
    found = [entry for entry in recording.entries() if "transition" in entry.channel.topic]
    assert found
    assert all(entry.channel.topic == "/test/transition_event" for entry in found)


def test_the_log_is_recorded_as_rosout(recording: Recording) -> None:
    LogChannel(recording.recorder).write(1_500_000_000, 30, "robot", "low battery")
    [entry] = recording.entries()
    assert entry.channel.topic == LOG_TOPIC
    assert entry.schema is not None
    assert entry.schema.name == "rcl_interfaces/msg/Log"
    log = deserialize(entry.message.data, Log)
    assert (log.level, log.name, log.msg, log.stamp.sec) == (30, "robot", "low battery", 1)
