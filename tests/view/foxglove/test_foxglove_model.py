"""The parts of the Foxglove server that need no programs: names, streams, values, transforms."""

import argparse
import math
from functools import partial
from typing import Any

import attrs
import pytest
from foxglove import ParameterType
from hypothesis import given
from hypothesis import strategies as st

from rosbase import ConfigurationError
from rosbase.messages import Header, Imu, Quaternion, Time
from rosbase.messages.tf2_msgs import TFMessage
from rosbase.wire import deserialize, serialize
from rosbase_view import command
from rosbase_view.attached.wanted import Tag
from rosbase_view.foxglove.graph import links
from rosbase_view.foxglove.names import NameTable, candidates
from rosbase_view.foxglove.transforms import Transforms
from rosbase_view.foxglove.values import from_parameter, to_parameter
from rosbase_view.foxglove.wanted import MOST_WAITING, Listened, wanted
from rosbase_view.foxglove.worker import Worker
from support.viewing import IMU_TOPIC, PID, made_topic, survey
from support.waiting import wait_until

OTHER: tuple[str, int] = ("/imu/data", PID + 1)


def test_a_name_is_kept_and_a_second_one_has_that_of_its_program() -> None:
    names: NameTable[tuple[str, int]] = NameTable()
    first, second, third = (candidates("/imu", "/robot", pid) for pid in (1, 2, 3))
    assert names.update({("a", 1): first}) == {"/imu": ("a", 1)}
    both = names.update({("a", 2): second, ("a", 1): first, ("a", 3): third})
    assert both == {"/imu": ("a", 1), "/robot/imu": ("a", 2), "/robot_3/imu": ("a", 3)}
    # Whoever is left keeps its name, and what comes takes the one that is free.
    assert names.update({("a", 2): second}) == {"/robot/imu": ("a", 2)}
    assert names.update({("a", 4): first, ("a", 2): second})["/imu"] == ("a", 4)


def test_a_program_that_started_again_has_its_name_again() -> None:
    names: NameTable[int] = NameTable()
    names.update({1: candidates("/imu", "/robot", 1)})
    assert names.update({2: candidates("/imu", "/robot", 2)}) == {"/imu": 2}


_KEYS = st.integers(0, 5)


@given(st.lists(st.dictionaries(_KEYS, st.sampled_from(["/a", "/b"]))))
def test_no_two_things_have_one_name(rounds: list[dict[int, str]]) -> None:
    names: NameTable[int] = NameTable()
    for wanted_names in rounds:
        found = names.update(
            {key: candidates(name, "/robot", key) for key, name in wanted_names.items()}
        )
        assert sorted(found.values()) == sorted(wanted_names)


def test_only_topics_with_listeners_have_streams() -> None:
    nothing: frozenset[Any] = frozenset()
    assert not wanted(survey(), Listened({}, nothing))
    (tag,) = streams = wanted(survey(), Listened({IMU_TOPIC: 1}, nothing))
    assert tag == Tag("echo", IMU_TOPIC, PID)
    assert streams[tag].arguments == {"topic": "/imu/data", "limit": MOST_WAITING}
    # A transform is made of some of the messages, whether others are heard or not.
    (tag,) = streams = wanted(survey(), Listened({}, frozenset([IMU_TOPIC])))
    assert tag == Tag("transform", IMU_TOPIC, PID)
    assert streams[tag].arguments == {"topic": "/imu/data", "limit": 1, "every_ns": 20_000_000}
    # One that has gone.
    assert not wanted(survey(), Listened({("/gone", PID): 1}, nothing))


def test_another_listener_needs_another_stream_only_of_messages_that_are_kept() -> None:
    kept: Any = made_topic("/imu/data")
    kept["publishers"][0]["qos"] = {"durability": "transient_local"}
    found = attrs.evolve(survey(), topics={IMU_TOPIC: kept})
    first, second = (wanted(found, Listened({IMU_TOPIC: n}, frozenset())) for n in (1, 2))
    assert first != second
    first, second = (wanted(survey(), Listened({IMU_TOPIC: n}, frozenset())) for n in (1, 2))
    assert first == second


@pytest.mark.parametrize(
    ("kind", "value", "type_"),
    [
        ("bool", True, None),
        ("integer", 2**40, None),
        ("double", 2.0, ParameterType.Float64),
        ("string", "text", None),
        ("byte_array", [0, 255], ParameterType.ByteArray),
        ("bool_array", [True, False], None),
        ("integer_array", [1, 2], None),
        ("double_array", [1.0, 2.0], ParameterType.Float64Array),
        ("double_array", [], ParameterType.Float64Array),
        ("string_array", ["a", ""], None),
        ("string_array", [], None),
    ],
)
def test_values_of_all_types_go_to_clients_and_come_back(
    kind: str, value: Any, type_: ParameterType | None
) -> None:
    parameter = to_parameter("/arm.x", kind, value)
    assert parameter.name == "/arm.x"
    assert parameter.type == type_
    back = from_parameter(parameter)
    assert back == value
    assert type(back) is type(value)


def test_a_whole_number_for_a_double_is_a_double_for_clients() -> None:
    assert type(from_parameter(to_parameter("x", "double", 2))) is float


def imu(orientation: Quaternion, frame: str = "imu_link", **fields: Any) -> bytes:
    return bytes(serialize(Imu(Header(Time(3, 4), frame), orientation, **fields)))


TURNED = Quaternion(0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))


def test_an_orientation_is_a_transform_to_the_world() -> None:
    data = Transforms().of(IMU_TOPIC, imu(TURNED))
    assert data is not None
    (found,) = deserialize(data, TFMessage).transforms
    assert found.header == Header(Time(3, 4), "world")
    assert found.child_frame_id == "imu_link"
    assert found.transform.rotation == TURNED
    assert found.transform.translation.x == 0.0


@given(*(st.floats(-1e3, 1e3) for _ in range(4)))
def test_a_transform_has_norm_1_whatever_the_device_sends(
    x: float, y: float, z: float, w: float
) -> None:
    data = Transforms().of(IMU_TOPIC, imu(Quaternion(x, y, z, w)))
    if data is None:
        assert math.hypot(x, y, z, w) < 1e-150
        return
    (found,) = deserialize(data, TFMessage).transforms
    turned = found.transform.rotation
    assert math.hypot(turned.x, turned.y, turned.z, turned.w) == pytest.approx(1.0)


def test_an_imu_without_an_orientation_has_no_transform() -> None:
    unknown = (-1.0,) + (0.0,) * 8
    assert Transforms().of(IMU_TOPIC, imu(TURNED, orientation_covariance=unknown)) is None
    assert Transforms().of(IMU_TOPIC, imu(Quaternion(0.0, 0.0, 0.0, 0.0))) is None
    assert Transforms().of(IMU_TOPIC, imu(Quaternion(math.nan, 0.0, 0.0, 1.0))) is None
    assert Transforms().of(IMU_TOPIC, b"no Imu") is None


def test_two_topics_of_one_frame_do_not_turn_it_in_turns() -> None:
    transforms = Transforms()
    assert transforms.of(IMU_TOPIC, imu(TURNED))
    assert transforms.of(OTHER, imu(TURNED)) is None
    assert transforms.of(OTHER, imu(TURNED, "other_link"))
    transforms.keep([OTHER])
    assert transforms.of(OTHER, imu(TURNED))


def test_an_imu_without_a_frame_has_that_of_its_topic() -> None:
    data = Transforms().of(IMU_TOPIC, imu(TURNED, ""))
    assert data is not None
    assert deserialize(data, TFMessage).transforms[0].child_frame_id == "imu/data"


def test_links_are_of_nodes_by_the_names_that_clients_see() -> None:
    topic = made_topic("/imu/data", publishers=[1, 2], subscribers=[1])
    found = links({"/left/imu/data": topic}, {"/enable": ["/b", "/a", "/a"]})
    assert found.published == {"/left/imu/data": ["/quadruped"]}
    assert found.subscribed == {"/left/imu/data": ["/quadruped"]}
    assert found.offered == {"/enable": ["/a", "/b"]}


def test_a_worker_does_jobs_in_their_order_and_takes_no_more_than_it_has_room_for() -> None:
    failures: list[Exception] = []
    worker = Worker("test", 3, failures.append)
    done: list[int] = []
    jobs = [worker.add(partial(done.append, number)) for number in range(5)]
    assert [job is None for job in jobs] == [False, False, False, True, True]
    assert jobs[0] is not None
    assert not jobs[0].wait(0.0)
    worker.start()
    wait_until(lambda: len(done) == 3, "the jobs")
    assert done == [0, 1, 2]
    assert jobs[2] is not None
    assert jobs[2].wait(1.0)
    worker.close()
    assert worker.add(lambda: None) is None
    assert not failures


def test_a_worker_whose_job_fails_tells_so() -> None:
    failures: list[Exception] = []
    worker = Worker("test", 3, failures.append)
    worker.start()
    worker.add(lambda: 1 / 0)
    wait_until(lambda: failures, "the failure")
    assert isinstance(failures[0], ZeroDivisionError)
    worker.close()


def test_a_missing_extra_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "find_spec", lambda _: None)
    parser = argparse.ArgumentParser()
    command.configure(parser)
    with pytest.raises(ConfigurationError, match=r"--foxglove needs foxglove.*pip install"):
        command.run(parser.parse_args(["--foxglove"]))
