"""Names that users give, and which programs hear each other: the pure parts of the client."""

from typing import Any

import pytest

from rosbase.control.answers import lookup
from rosbase.control.buses import buses, observers, on_several, with_children
from rosbase.control.joined_topics import joined_topics
from rosbase.control.names import full_type, is_hidden, one_of, similar, unknown
from rosbase.control.programs import RunningNode
from rosbase.errors import ControlError
from support.control import FakeProgram


def process(
    pid: int, backend: str | None, *children: int, kind: str = "manager", network: str = ""
) -> Any:
    program = {
        "backend": backend,
        "network": network,
        "kind": kind,
        "children": [{"name": "c", "pid": child, "running": True} for child in children],
    }
    return {"pid": pid, "programs": [program]}


def grouped(*processes: Any) -> set[tuple[str, frozenset[int]]]:
    return {(bus.backend, bus.pids) for bus in buses(processes)}


def topic(publishers: list[int], subscribers: list[int]) -> Any:
    return {
        "name": "/x",
        "types": [],
        "publishers": [{"pid": pid} for pid in publishers],
        "subscriptions": [{"pid": pid} for pid in subscribers],
    }


def test_programs_on_local_are_alone_and_those_on_ros_are_joined() -> None:
    assert grouped(
        process(1, "local"), process(2, "local"), process(3, "ros2"), process(4, "ros2")
    ) == {
        ("local", frozenset({1})),
        ("local", frozenset({2})),
        ("ros2", frozenset({3, 4})),
    }


def test_a_process_is_listed_with_all_that_descend_from_it() -> None:
    launcher = process(1, None, 2, 9, kind="launcher")
    processes = [launcher, process(2, "local", 3), process(3, "local"), process(4, "local")]
    assert [p["pid"] for p in with_children(launcher, processes)] == [1, 2, 3]
    assert [p["pid"] for p in with_children(processes[3], processes)] == [4]


def test_children_in_a_circle_are_listed_once() -> None:
    circle = [process(1, "local", 2), process(2, "local", 1)]
    assert [p["pid"] for p in with_children(circle[0], circle)] == [1, 2]


def test_topics_of_several_programs_are_joined_in_each_group() -> None:
    def told(kind: str, end: str) -> Any:
        ends = {"publishers": [], "subscriptions": [], end: [{"node": "/n"}]}
        return {"name": "/x", "type": kind, **ends}

    answers = [(1, [told("A", "publishers")]), (2, [told("B", "subscriptions")]), (7, [])]
    ((key, joined),) = joined_topics(answers).items()
    assert key == ("/x", 0)
    assert joined["types"] == ["A", "B"]
    assert joined["publishers"] == [{"node": "/n", "pid": 1}]
    assert joined["subscriptions"] == [{"node": "/n", "pid": 2}]
    assert list(joined_topics(answers, lambda pid: pid)) == [("/x", 1), ("/x", 2)]


def test_programs_in_two_ros_domains_are_not_joined() -> None:
    processes = [process(pid, "ros2", network=str(domain)) for pid, domain in ((1, 0), (2, 7))]
    one_without = process(3, "ros2")
    del one_without["programs"][0]["network"]
    assert grouped(*processes, process(4, "ros2", network="7"), one_without) == {
        ("ros2", frozenset({1})),
        ("ros2", frozenset({2, 4})),
        ("ros2", frozenset({3})),
    }


def test_children_are_on_the_bus_of_their_manager_also_those_of_children() -> None:
    found = grouped(process(1, "local", 2, 9), process(2, "local", 3), process(3, "local"))
    assert found == {("local", frozenset({1, 2, 3}))}


def test_programs_of_a_launcher_are_programs_of_their_own() -> None:
    found = grouped(
        process(1, None, 2, 3, kind="launcher"), process(2, "local"), process(3, "local")
    )
    assert ("local", frozenset({2})) in found
    assert ("local", frozenset({3})) in found


@pytest.mark.parametrize(
    ("publishers", "subscribers", "seen_in"),
    [
        ([1], [], [1]),
        ([1], [2], [1]),
        ([], [2, 3], [2]),
        ([1, 2], [], [1, 2]),
        ([1, 2], [2, 3], [2]),
        ([1, 2], [3], [3]),
    ],
)
def test_each_message_is_seen_once(
    publishers: list[int], subscribers: list[int], seen_in: list[int]
) -> None:
    (bus,) = buses([process(pid, "ros2") for pid in (1, 2, 3)])
    assert observers(topic(publishers, subscribers), bus) == seen_in


def test_a_topic_is_on_the_buses_of_its_ends() -> None:
    both = buses([process(1, "local"), process(2, "local"), process(3, "local")])
    assert [bus.pids for bus in on_several(topic([1], [3]), both)] == [{1}, {3}]


def test_a_name_without_its_slash_and_in_one_program_is_found() -> None:
    owners = {"/camera": [1], "/arm": [1, 2]}
    assert one_of("node", "camera", owners, {}) == ("/camera", 1)
    with pytest.raises(ControlError, match=r"^node /arm is in 2 programs: left \[1\], 2; choose"):
        one_of("node", "arm", owners, {1: "left [1]"})
    with pytest.raises(ControlError, match=r"^no node camra; did you mean /camera\?$") as caught:
        one_of("node", "camra", owners, {})
    assert (caught.value.kind, caught.value.suggestions) == ("unknown", ["/camera"])


def test_the_last_part_of_a_name_is_enough_for_a_suggestion() -> None:
    assert similar("data", ["/imu/data", "/gps/data", "/date"])[:2] == ["/gps/data", "/imu/data"]
    assert str(unknown("topic", "zzz", [f"/t{n}" for n in range(12)])).endswith("/t7, ...")
    assert str(unknown("topic", "zzz", [])) == "no topic zzz; there is no topic at all"


def test_types_are_completed_and_hidden_names_known() -> None:
    assert full_type("std_msgs/String") == "std_msgs/msg/String"
    assert full_type("std_srvs/Trigger", "srv") == "std_srvs/srv/Trigger"
    assert full_type("std_msgs/msg/String") == "std_msgs/msg/String"
    assert full_type("String") == "String"
    assert is_hidden("/a/_b")
    assert not is_hidden("/a_/b")


class Twin(FakeProgram):
    def nodes(self) -> list[RunningNode]:
        return [RunningNode("/twin", "", "Twin", None)]


def test_programs_of_one_process_with_the_same_name_are_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(lookup, "running_programs", lambda: (Twin(), Twin()))
    with pytest.raises(ControlError) as caught:
        lookup.find_node("twin")
    assert caught.value.kind == "ambiguous"
    assert str(caught.value).startswith(
        "node twin is in 2 programs of one process: /fake (Twin), /fake (Twin); "
    )
