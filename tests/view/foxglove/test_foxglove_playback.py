"""A recording that clients play, as Foxglove's controls do, with a client of the protocol only."""

import math
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from rosbase.messages import String
from rosbase.messages.tf2_msgs import TFMessage
from rosbase.wire import deserialize
from support.command import RunningRosbase
from support.foxglove_client import FoxgloveClient
from support.foxglove_served import port_of
from support.made_recording import BEGIN_NS, STEP_NS, number_of
from support.waiting import wait_until

pytestmark = pytest.mark.timeout(120)

PLAYING, PAUSED, ENDED = 0, 1, 3
COUNT = 300
PLAYER = f"""
from rosbase_view.foxglove.show import run
from rosbase_view.options import Options
from rosbase_view.recorded.source import RecordedSource
from support.made_recording import MadeRecording

source = RecordedSource(MadeRecording({COUNT}))
raise SystemExit(run(source, Options(view="foxglove", name="day.mcap", host="127.0.0.1", port=0)))
"""


@contextmanager
def played() -> Iterator[int]:
    """Serves a made recording in a process of its own; gives the port."""
    tests = str(Path(__file__).parents[2])
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (tests, before)))
    try:
        view = RunningRosbase("-c", PLAYER, program=sys.executable)
    finally:
        os.environ.pop("PYTHONPATH")
        if before is not None:
            os.environ["PYTHONPATH"] = before
    with view:
        yield port_of(view)
        assert view.end(signal.SIGINT) == 0
        assert not view.err.lines


@pytest.fixture
def client() -> Iterator[FoxgloveClient]:
    with played() as port, FoxgloveClient(port) as found:
        yield found


def numbers(client: FoxgloveClient) -> list[int]:
    return [number_of(one.data) for one in client.of("/imu/data")]


def is_over(client: FoxgloveClient) -> bool:
    return bool(client.playback) and client.playback[-1]["state"] == ENDED


def is_complete(client: FoxgloveClient) -> bool:
    """The SDK sends states before messages that wait."""
    return is_over(client) and numbers(client)[-1:] == [COUNT - 1]


def at(number: int) -> int:
    return BEGIN_NS + number * STEP_NS


def test_the_time_range_and_the_topics_are_told(client: FoxgloveClient) -> None:
    assert set(client.info["capabilities"]) == {"time", "playbackControl"}
    assert client.info["name"] == "rosbase: day.mcap"
    for name, time_ns in (("dataStartTime", at(0)), ("dataEndTime", at(COUNT - 1))):
        found = client.info[name]
        assert found["sec"] * 1_000_000_000 + found["nsec"] == time_ns
    assert client.channel("/imu/data")["schemaName"] == "sensor_msgs/msg/Imu"
    assert client.channel("/model")["schema"] == "string data\n"


def test_it_begins_when_a_client_listens_and_ends_at_its_end(client: FoxgloveClient) -> None:
    client.channel("/imu/data")
    client.until(lambda: len(client.times) > 5, "the time")
    assert set(client.times) == {at(0)}
    client.subscribe("/imu/data")
    client.subscribe("/model")
    client.until(lambda: is_complete(client), "the end")
    assert numbers(client) == list(range(COUNT))
    assert [one.stamp_ns for one in client.of("/imu/data")] == [at(n) for n in range(COUNT)]
    assert deserialize(client.of("/model")[0].data, String).data == "a board"
    assert client.times == sorted(client.times)
    client.until(lambda: client.times[-1] == at(COUNT - 1), "the last time")


def test_pause_speed_and_jump(client: FoxgloveClient) -> None:
    client.subscribe("/imu/data")
    client.until(lambda: len(numbers(client)) > 10, "messages")
    request = client.control(plays=False)
    client.until(lambda: client.playback[-1]["state"] == PAUSED, "the pause")
    assert request in [one["request"] for one in client.playback]
    client.until(lambda: len(client.times) > 10, "the time")
    request = client.control(plays=False, seek_ns=at(200))
    client.until(lambda: numbers(client)[-1] == 199, "what was known then")
    answer = next(one for one in client.playback if one["request"] == request)
    assert (answer["state"], answer["now_ns"], answer["did_seek"]) == (PAUSED, at(200), True)
    client.until(lambda: client.times[-1] == at(200), "the time")
    client.control(plays=True, speed=2.0)
    client.until(lambda: is_complete(client), "the end")
    assert client.playback[-1]["speed"] == 2.0
    found = numbers(client)
    assert found[found.index(199) :] == list(range(199, COUNT))
    # Back again, while it plays.
    count = len(found)
    client.control(plays=True, speed=4.0, seek_ns=at(100))
    client.until(lambda: numbers(client)[-1] == COUNT - 1 and len(numbers(client)) > count, "again")
    assert numbers(client)[count:] == list(range(99, COUNT))


@pytest.mark.parametrize("speed", [0.0, -1.0, math.nan, math.inf])
def test_a_speed_that_is_none_is_left_as_it_was(client: FoxgloveClient, speed: float) -> None:
    client.subscribe("/imu/data")
    request = client.control(plays=True, speed=speed, seek_ns=at(250))
    client.until(lambda: is_complete(client), "the end")
    answer = next(one for one in client.playback if one["request"] == request)
    assert answer["speed"] == 1.0


@pytest.mark.parametrize(("asked", "state"), [(-5, PLAYING), (COUNT + 5, ENDED)])
def test_a_jump_out_of_the_recording_ends_at_its_edge(
    client: FoxgloveClient, asked: int, state: int
) -> None:
    client.channel("/imu/data")
    request = client.control(plays=True, seek_ns=at(asked))
    client.until(lambda: request in [one["request"] for one in client.playback], "the answer")
    wait_until(lambda: client.playback[-1]["state"] == state, "the state")


def test_another_client_gets_what_came_once(client: FoxgloveClient) -> None:
    client.subscribe("/model")
    client.until(lambda: is_over(client), "the end")
    with FoxgloveClient(client.port) as other:
        other.subscribe("/model")
        other.until(lambda: other.of("/model"), "the message")


def test_a_board_of_a_recording_is_turned_fifty_times_a_second(client: FoxgloveClient) -> None:
    client.subscribe("/imu/data")
    client.subscribe("/tf")
    client.until(lambda: is_complete(client), "the end")
    # Of a hundred messages a second.
    assert len(client.of("/tf")) == COUNT // 2


def test_a_board_of_a_recording_is_turned(client: FoxgloveClient) -> None:
    client.subscribe("/tf")
    client.until(lambda: len(client.of("/tf")) > 10, "transforms")
    (found,) = deserialize(client.of("/tf")[10].data, TFMessage).transforms
    assert found.child_frame_id == "imu_link"
    assert found.transform.rotation.z > 0.0
