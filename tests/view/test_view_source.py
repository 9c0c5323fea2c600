"""The source of running programs: what it asks, and what it keeps for a slow view."""

from typing import Any

import attrs
import pytest

from rosbase import ControlError
from rosbase.messages import Point
from rosbase.wire import schema, serialize
from rosbase_view.attached.choosing import chosen
from rosbase_view.attached.inbox import Inbox
from rosbase_view.attached.refusals import Refusals
from rosbase_view.attached.source import AttachedSource
from rosbase_view.attached.wanted import Tag, wanted
from rosbase_view.known import MOST_RECORDS
from rosbase_view.reports import Counted, Heard, Logged, Said, TopicKey
from rosbase_view.source import Gaze, Pace
from support.viewing import IMU_TOPIC, PID, made_process, made_program, made_topic, survey

POINT = "geometry_msgs/msg/Point"
CHILD = PID + 1


def parent_and_child() -> list[Any]:
    children = [{"name": "camera", "pid": CHILD, "running": True}]
    return [
        made_process(PID, made_program(children=children)),
        made_process(CHILD, made_program("/camera", kind="node")),
        made_process(9, made_program("/other")),
    ]


@pytest.mark.parametrize("name", ["quadruped", "/quadruped", str(PID)])
def test_a_program_is_looked_at_with_its_children(name: str) -> None:
    assert [p["pid"] for p in chosen(parent_and_child(), name)] == [PID, CHILD]


def test_a_child_and_all_programs_can_be_looked_at() -> None:
    assert [p["pid"] for p in chosen(parent_and_child(), "camera")] == [CHILD]
    assert len(chosen(parent_and_child(), None)) == 3


def test_a_wrong_name_has_suggestions() -> None:
    with pytest.raises(ControlError, match="quadruped") as caught:
        chosen(parent_and_child(), "quadrupd")
    assert caught.value.kind == "unknown"


def test_a_name_of_two_programs_is_ambiguous() -> None:
    twice = [made_process(1), made_process(2)]
    with pytest.raises(ControlError, match=r"name the pid: rosbase view 1$") as caught:
        chosen(twice, "quadruped")
    assert caught.value.kind == "ambiguous"


def test_a_wrong_name_is_answered_with_names() -> None:
    with pytest.raises(ControlError, match=r"there are: camera, other, quadruped$"):
        chosen(parent_and_child(), "mine")


def test_only_the_topic_that_is_looked_at_sends_messages() -> None:
    streams = wanted(survey(), Gaze())
    assert {tag.kind for tag in streams} == {"log", "counts"}
    with_gaze = wanted(survey(), Gaze(topics=frozenset({IMU_TOPIC})))
    new = set(with_gaze) - set(streams)
    assert new == {Tag("echo", IMU_TOPIC, PID)}
    assert with_gaze[new.pop()].arguments == {
        "topic": "/imu/data", "limit": 1, "every_ns": 50_000_000,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("topics", "every_s", "streams"), [(1, 0.1, 1), (50, 0.1, 1), (201, 0.1, 2), (1_001, 0.5, 6)]
)
def test_few_streams_count_many_topics(topics: int, every_s: float, streams: int) -> None:
    counts = [
        question.arguments
        for tag, question in wanted(survey(topics), Gaze()).items()
        if tag.kind == "counts"
    ]
    assert [one["every_ns"] / 1e9 for one in counts] == [every_s] * streams
    assert sorted(name for one in counts for name in one["topics"]) == sorted(
        name for name, _ in survey(topics).topics
    )


def test_a_message_between_two_processes_is_counted_once() -> None:
    processes = parent_and_child()[:2]
    topic = made_topic("/seen", POINT, publishers=[CHILD], subscribers=[PID])
    found = attrs.evolve(survey(), processes=processes, topics={("/seen", PID): topic})
    counted = [tag for tag in wanted(found, Gaze()) if tag.kind == "counts"]
    assert counted == [Tag("counts", ("0", PID), CHILD)]


def count(inbox: Inbox, topic: TopicKey, pid: int, number: int, seconds: float = 0.1) -> None:
    name, first_pid = topic
    had = {name: {"count": number, "age_ns": 20_000_000}} if number else {}
    tag, answer = Tag("counts", ("0", first_pid), pid), {"topics": {name: "x/Y"}}
    inbox.put_event(tag, answer, {"seconds": seconds, "topics": had}, b"")


def test_counts_add_up_while_nobody_takes_them() -> None:
    inbox = Inbox()
    for _ in range(10_000):
        count(inbox, IMU_TOPIC, PID, 20)
    (counted,) = inbox.take()
    assert isinstance(counted, Counted)
    assert counted.count == 200_000
    assert counted.seconds == pytest.approx(1_000.0)
    assert inbox.take() == []


def test_two_publishers_of_one_topic_are_one_rate() -> None:
    inbox = Inbox()
    count(inbox, IMU_TOPIC, PID, 20)
    count(inbox, IMU_TOPIC, CHILD, 10)
    assert inbox.take() == [Counted(IMU_TOPIC, 30, 0.1, 0.02)]


def test_a_topic_without_messages_is_counted_too() -> None:
    inbox = Inbox()
    count(inbox, IMU_TOPIC, PID, 0)
    assert inbox.take() == [Counted(IMU_TOPIC, 0, 0.1, 0.0)]
    count(inbox, IMU_TOPIC, PID, 1)
    count(inbox, IMU_TOPIC, PID, 0)
    assert inbox.take() == [Counted(IMU_TOPIC, 1, 0.2, 0.02 + 0.1)]


def heard(inbox: Inbox, data: bytes) -> None:
    answer = {"type": POINT, "schema": schema(Point)}
    inbox.put_event(Tag("echo", ("/p", PID), PID), answer, {"stamp_ns": 5, "dropped": 7}, data)


def test_the_last_message_is_read_and_those_before_are_not() -> None:
    inbox = Inbox()
    heard(inbox, b"no message at all")
    heard(inbox, bytes(serialize(Point(1.0, 2.0, 3.0))))
    (last,) = inbox.take()
    assert isinstance(last, Heard)
    assert (last.topic, last.type, last.stamp_ns, last.dropped) == (("/p", PID), POINT, 5, 7)
    assert last.message == {"x": 1.0, "y": 2.0, "z": 3.0}
    # It is read once.
    assert last.message is last.message


def test_each_message_is_kept_if_all_are_wanted() -> None:
    inbox = Inbox()
    inbox.pace = Pace.ALL
    for number in range(3):
        heard(inbox, bytes([number]))
    assert [one.data for one in inbox.take() if isinstance(one, Heard)] == [b"\0", b"\1", b"\2"]


def test_messages_that_nobody_takes_are_counted_and_do_not_add_up() -> None:
    inbox = Inbox()
    inbox.pace = Pace.ALL
    for _ in range(10_003):
        heard(inbox, b"")
    taken = inbox.take()
    assert len(taken) == 10_000
    assert isinstance(taken[-1], Heard)
    assert taken[-1].dropped == 7 + 3


def test_whoever_waits_is_told_of_news() -> None:
    news: list[str] = []
    inbox = Inbox(lambda: news.append("news"))
    count(inbox, IMU_TOPIC, PID, 1)
    inbox.put(Said("done"))
    assert news == ["news"] * 2


def test_the_log_keeps_its_newest_records_in_order() -> None:
    inbox = Inbox()
    for number in reversed(range(MOST_RECORDS + 5)):
        event = {"stamp_ns": number, "level": 20, "name": "robot", "text": str(number)}
        inbox.put_event(Tag("log", ("", 0), PID), {}, event, b"")
    (logged,) = inbox.take()
    assert isinstance(logged, Logged)
    assert [record["stamp_ns"] for record in logged.records] == list(range(MOST_RECORDS))


def test_a_survey_comes_before_the_counts_of_its_topics() -> None:
    inbox = Inbox()
    count(inbox, IMU_TOPIC, PID, 1)
    inbox.put(survey())
    inbox.put(Said("first"))
    inbox.put(Said("second"))
    assert inbox.take() == [survey(), Counted(IMU_TOPIC, 1, 0.1, 0.02), Said("second")]


def test_a_stream_that_is_refused_is_named_with_the_reason_while_it_is_wanted() -> None:
    counts, log = Tag("counts", ("0", PID), PID), Tag("log", ("", 0), PID)
    refusals = Refusals()
    assert refusals.line([made_process()]) == ""
    refusals.add(counts, "64 streams are open")
    refusals.add(counts._replace(topic=("1", PID)), "64 streams are open")
    assert refusals.line([made_process()]) == "no rates of quadruped [4711]: 64 streams are open"
    refusals.add(log, "no")
    refusals.keep([log])
    assert refusals.line([made_process()]) == "no log of quadruped [4711]: no"
    refusals.forget(log)
    assert refusals.line([made_process()]) == ""


def test_refused_rates_are_told_by_the_source() -> None:
    source = AttachedSource()
    source._refused(Tag("counts", ("0", PID), PID), "64 streams are open")
    assert "64 streams are open" in source._with_refusals(survey()).trouble
    source._take(
        Tag("counts", ("0", PID), PID), {"topics": {}}, {"seconds": 0.1, "topics": {}}, b""
    )
    assert source._with_refusals(survey()).trouble == ""
    source.close()
