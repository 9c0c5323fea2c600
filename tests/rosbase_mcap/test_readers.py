"""Recordings as other programs read them: mcap with ROS 2, and rosbags."""

from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from rosbase import DurabilityPolicy, QoSProfile, RecordOptions, make_logger
from rosbase.messages import Header, Imu, Time, TransformStamped, Vector3
from rosbase.testing import virtual_backend
from rosbase_mcap.program_recording import ProgramRecording


@pytest.fixture(params=["", "lz4", "zstd"])
def path(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A recording of an Imu and of a latched topic."""
    made = tmp_path / "run.mcap"
    backend = virtual_backend()
    imu = backend.create_publisher(Imu, "imu/data", 10)
    latched = QoSProfile(1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    frame = backend.create_publisher(TransformStamped, "mounted", latched)
    recording = ProgramRecording(RecordOptions(made, compression=request.param))
    frame.publish(TransformStamped(Header(Time(1, 2), "base"), "imu_link"))
    recording.begin(backend, make_logger("test"))
    for number in range(100):
        rate = Vector3(float(number), 0.0, -1.5)
        imu.publish(Imu(Header(Time(number, 5), "imu_link"), angular_velocity=rate))
    backend.close()
    recording.close(None)
    return made


def test_mcap_reads_the_messages_of_ros_2(path: Path) -> None:
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        found = [(channel.topic, read) for _, channel, _, read in reader.iter_decoded_messages()]
    imus = [message for topic, message in found if topic == "/imu/data"]
    assert [imu.angular_velocity.x for imu in imus] == [float(number) for number in range(100)]
    assert imus[0].header.frame_id == "imu_link"
    [frame] = [message for topic, message in found if topic == "/mounted"]
    assert (frame.child_frame_id, frame.transform.rotation.w) == ("imu_link", 1.0)


def test_rosbags_reads_the_messages_and_the_profiles(path: Path) -> None:
    with AnyReader([path]) as reader:
        topics = {connection.topic: connection for connection in reader.connections}
        assert topics["/imu/data"].msgtype == "sensor_msgs/msg/Imu"
        assert topics["/imu/data"].msgcount == 100
        assert "durability=<QosDurability.TRANSIENT_LOCAL" in str(topics["/mounted"].ext)
        found: list[Any] = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages([topics["/imu/data"]])
        ]
    assert [imu.angular_velocity.x for imu in found] == [float(number) for number in range(100)]
