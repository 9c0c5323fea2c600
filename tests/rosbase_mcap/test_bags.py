"""Bags of any origin, as a replay of topics reads them."""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from rosbase import NotInstalledError
from rosbase.contracts.message_format import message_format
from rosbase.messages import Header, Imu, Time, Vector3
from rosbase_mcap.bags import BagTopic, open_bag
from rosbase_mcap.channel_table import ChannelTable
from rosbase_mcap.errors import McapError
from rosbase_mcap.file_sink import declare
from rosbase_mcap.file_writer import FileWriter
from support.bag_reading import LEAVES_OPEN, with_reason

S = 1_000_000_000
COUNT = 5
SECONDS = range(1, COUNT + 1)
NAME = "sensor_msgs/msg/Imu"
FORM = message_format(Imu)


def imu_of(store: object, second: int, **of_header: object) -> object:
    types = store.types  # type: ignore[attr-defined]  # rosbags does not declare it
    stamp = types["builtin_interfaces/msg/Time"](sec=second, nanosec=7)
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="imu_link", **of_header)
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    return types[NAME](
        header,
        quaternion(0.0, 0.0, 0.0, 1.0),
        np.zeros(9),
        vector(float(second), 2.0, 3.0),
        np.zeros(9),
        vector(0.0, 0.0, 9.81),
        np.zeros(9),
    )


def of_rosbag2(folder: Path, plugin: StoragePlugin) -> Path:
    store = get_typestore(Stores.ROS2_HUMBLE)
    path = folder / "bag"
    with Writer2(path, version=9, storage_plugin=plugin) as writer:
        imu = writer.add_connection("/imu/data", NAME, typestore=store)
        text = writer.add_connection("/text", "std_msgs/msg/String", typestore=store)
        string = store.types["std_msgs/msg/String"]
        for second in SECONDS:
            data = store.serialize_cdr(imu_of(store, second), NAME)
            writer.write(imu, second * S, data)
            line = store.serialize_cdr(string(data="x"), "std_msgs/msg/String")
            writer.write(text, second * S, line)
    return path


def of_ros_1(folder: Path) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    path = folder / "run.bag"
    with Writer1(path) as writer:
        imu = writer.add_connection("imu/data", NAME, typestore=store)
        for second in SECONDS:
            data = store.serialize_ros1(imu_of(store, second, seq=second), NAME)
            writer.write(imu, second * S, data)
    return path


def of_rosbase(folder: Path) -> Path:
    pieces, table = list[bytes | memoryview](), ChannelTable()
    writer = FileWriter(pieces.append)
    number = table.add("/imu/data", FORM.type_name, FORM.schema, {})
    declare(writer, table, [number])
    for second in SECONDS:
        writer.add(number, 0, second * S, second * S, FORM.encode(imu(second)))
    writer.finish()
    path = folder / "run.mcap"
    path.write_bytes(b"".join(pieces))
    return path


def imu(second: int) -> Imu:
    header = Header(Time(second, 7), "imu_link")
    rates, forces = Vector3(float(second), 2.0, 3.0), Vector3(0.0, 0.0, 9.81)
    return Imu(header, angular_velocity=rates, linear_acceleration=forces)


BAGS: dict[str, Callable[[Path], Path]] = {
    "rosbase": of_rosbase,
    "rosbag2 in SQLite": lambda folder: of_rosbag2(folder, StoragePlugin.SQLITE3),
    "rosbag2 in MCAP": lambda folder: of_rosbag2(folder, StoragePlugin.MCAP),
    "a file of rosbag2 in SQLite": lambda folder: (
        of_rosbag2(folder, StoragePlugin.SQLITE3) / "bag.db3"
    ),
    "a file of rosbag2 in MCAP": lambda folder: of_rosbag2(folder, StoragePlugin.MCAP) / "bag.mcap",
    "ROS 1": of_ros_1,
}


@pytest.mark.parametrize("make", [with_reason(make, name) for name, make in BAGS.items()])
def test_messages_come_as_ros_2_has_them(make: Callable[[Path], Path], tmp_path: Path) -> None:
    with open_bag(make(tmp_path)) as bag:
        assert bag.topics["/imu/data"] == BagTopic(NAME)
        assert bag.start_ns == S
        found = list(bag.messages(["/imu/data"]))
        again = list(bag.messages(["/imu/data"]))
    assert [one.log_ns for one in found] == [second * S for second in SECONDS]
    assert [FORM.decode(one.data) for one in found] == [imu(second) for second in SECONDS]
    assert again == found


@pytest.mark.parametrize("make", [with_reason(make, name) for name, make in BAGS.items()])
def test_only_the_topics_that_were_chosen_come(
    make: Callable[[Path], Path], tmp_path: Path
) -> None:
    with open_bag(make(tmp_path)) as bag:
        assert list(bag.messages([])) == []
        assert list(bag.messages(["/other"])) == []


@pytest.mark.parametrize("plugin", [with_reason(plugin, plugin.name) for plugin in StoragePlugin])
def test_messages_of_the_same_time_keep_their_order(plugin: StoragePlugin, tmp_path: Path) -> None:
    with open_bag(of_rosbag2(tmp_path, plugin)) as bag:
        topics = [one.topic for one in bag.messages(["/text", "/imu/data"])]
    assert topics == ["/imu/data", "/text"] * COUNT


def test_topics_that_are_latched_are_marked(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    latched = Qos(
        QosHistory.KEEP_LAST,
        1,
        QosReliability.RELIABLE,
        QosDurability.TRANSIENT_LOCAL,
        QosTime(0, 0),
        QosTime(0, 0),
        QosLiveliness.AUTOMATIC,
        QosTime(0, 0),
        avoid_ros_namespace_conventions=False,
    )
    for plugin in StoragePlugin if not LEAVES_OPEN else [StoragePlugin.MCAP]:
        path = tmp_path / plugin.name
        with Writer2(path, version=9, storage_plugin=plugin) as writer:
            writer.add_connection(
                "/tf_static", NAME, typestore=store, offered_qos_profiles=[latched]
            )
        with open_bag(path) as bag:
            assert bag.topics["/tf_static"].is_latched


def test_a_file_that_was_cut_off_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = of_rosbase(tmp_path)
    path.write_bytes(path.read_bytes()[:-600])
    with open_bag(path) as bag:
        assert bag.topics == {"/imu/data": BagTopic(NAME)}
        assert bag.start_ns == S
        assert 0 < len(list(bag.messages(bag.topics))) <= COUNT


@pytest.mark.parametrize("name", ["run.mcap", "run.db3", "run.bag", "run", "run.txt"])
def test_what_is_no_bag_is_refused_in_one_line(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    for write in (lambda: None, lambda: path.write_bytes(b"this is no bag"), path.unlink):
        write()
        with pytest.raises(McapError) as caught, open_bag(path):
            pass
        assert "\n" not in str(caught.value)
    path.mkdir()
    with pytest.raises(McapError, match=r"is a folder|this folder is no bag"), open_bag(path):
        pass


def test_without_rosbags_the_error_says_how_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(NotInstalledError, match="pip install"), open_bag(tmp_path):
        pass
