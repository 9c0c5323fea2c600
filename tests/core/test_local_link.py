"""Topics shared with another process: here, two buses of one, over a real socket pair."""

import socket
import threading
from collections.abc import Iterator
from multiprocessing.connection import Connection
from typing import Any

import pytest
from attrs import frozen

from rosbase.contracts.backend import BackendOptions, Publisher
from rosbase.local import Bus, LocalBackend
from rosbase.local.link import Link
from rosbase.messages import Header, Image, Imu, Time, Vector3
from rosbase.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, qos_profile_sensor_data
from support.waiting import wait_until

LATCHED = QoSProfile(3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Side:
    """A backend on a bus of its own, and its end of the link."""

    def __init__(self, end: socket.socket, name: str) -> None:
        self.bus = Bus()
        self.records: list[tuple[int, str, bool]] = []
        self.backend = LocalBackend(BackendOptions(name), self.bus)
        connection: Connection[Any, Any] = Connection(end.detach())
        self.link = Link(self.bus, connection, name, lambda *record: self.records.append(record))

    def subscribe(self, topic: str, profile: int | QoSProfile) -> list[int]:
        """A new subscription: the list into which its messages go, as numbers."""
        got: list[int] = []
        self.backend.create_subscription(Vector3, topic, lambda m: got.append(int(m.x)), profile)
        return got

    def knows_audience(self, topic: str) -> bool:
        return topic in self.bus._topics and bool(self.bus._topics[topic].subscriptions)


@pytest.fixture
def sides() -> Iterator[tuple[Side, Side]]:
    ends = socket.socketpair()
    pair = Side(ends[0], "here"), Side(ends[1], "there")
    for side in pair:
        side.link.start()
    yield pair
    for side in pair:
        side.link.close()
        side.link.close()
        side.backend.close()


def spin(side: Side, until: Any) -> None:
    deadline_ns = side.backend.clock.monotonic_ns() + 20 * 10**9
    side.backend.spin_until(deadline_ns, until)


def test_messages_arrive_in_order_none_lost_both_ways(sides: tuple[Side, Side]) -> None:
    for here, there in (sides, sides[::-1]):
        got: list[int] = []
        there.backend.create_subscription(Vector3, "scan", lambda v, g=got: g.append(v.x), 5000)  # type: ignore[misc]  # mypy infers no default of a lambda
        wait_until(lambda h=here: h.knows_audience("/scan"), "the audience")  # type: ignore[misc]  # mypy infers no default of a lambda
        publisher = here.backend.create_publisher(Vector3, "scan", 1)
        for number in range(2000):
            publisher.publish(Vector3(x=float(number)))
        spin(there, lambda g=got: len(g) >= 2000)
        assert got == list(range(2000))
        there.backend.close()
        there.backend = LocalBackend(BackendOptions("again"), there.bus)


def test_nothing_is_sent_that_nobody_wants(sides: tuple[Side, Side]) -> None:
    here, there = sides
    sent: list[Any] = []
    send = here.link._send

    def note(*values: Any) -> None:
        sent.append(values)
        send(*values)

    here.link._send = note  # type: ignore[method-assign]  # the test scripts it
    subscription = there.backend.create_subscription(Header, "scan", print, 1)
    wait_until(lambda: here.knows_audience("/scan"), "the audience")
    there.backend.destroy_subscription(subscription)
    wait_until(lambda: not here.knows_audience("/scan"), "the end of the audience")
    here.backend.create_publisher(Header, "scan", 1).publish(Header())
    here.backend.create_publisher(Header, "other", 1).publish(Header())
    here.link.close()
    assert sent == []


def test_a_message_does_not_come_back(sides: tuple[Side, Side]) -> None:
    here, there = sides
    got: dict[str, list[Header]] = {"here": [], "there": []}
    for name, side in zip(got, sides, strict=True):
        side.backend.create_subscription(Header, "scan", got[name].append, 10)
    wait_until(lambda: len(here.bus._topics["/scan"].subscriptions) == 2, "the audience")
    here.backend.create_publisher(Header, "scan", 1).publish(Header(frame_id="a"))
    spin(there, lambda: got["there"])
    there.backend.create_publisher(Header, "scan", 1).publish(Header(frame_id="b"))
    spin(here, lambda: len(got["here"]) == 2)
    assert [m.frame_id for m in got["here"]] == ["a", "b"]
    assert [m.frame_id for m in got["there"]] == ["a", "b"] or got["there"][0].frame_id == "a"


def test_a_slow_receiver_loses_the_oldest_and_never_blocks_the_publisher() -> None:
    ends = socket.socketpair()
    here = Side(ends[0], "here")
    here.link.start()
    there: Connection[Any, Any] = Connection(ends[1].detach())
    there.send(("want", "/scan", Vector3, "RELIABLE", QoSProfile(3)))
    wait_until(lambda: here.knows_audience("/scan"), "the audience")
    publisher = here.backend.create_publisher(Vector3, "scan", 1)
    for number in range(20_000):
        publisher.publish(Vector3(x=float(number)))
    got: list[float] = []
    thread = threading.Thread(target=here.link.close)
    thread.start()
    try:
        while True:
            what, *values = there.recv()
            got += [values[-1].x] if what == "message" else []
    except EOFError:
        thread.join()
    there.close()
    here.backend.close()
    assert got == sorted(got)
    assert got[-1] == 19_999
    assert len(got) < 20_000


def test_a_type_that_contradicts_is_reported_and_the_rest_goes_on(
    sides: tuple[Side, Side], caplog: pytest.LogCaptureFixture
) -> None:
    here, there = sides
    here.backend.create_publisher(Time, "scan", 1)
    there.backend.create_subscription(Header, "scan", print, 1)
    wait_until(lambda: "/scan carries Time, so it cannot carry Header" in caplog.text, "the report")
    there.backend.create_subscription(Header, "other", print, 1)
    wait_until(lambda: here.knows_audience("/other"), "the other topic")


@frozen
class Handle:
    """A message that cannot leave its process."""

    lock: Any


def test_a_message_that_cannot_be_pickled_is_reported_and_the_rest_goes_on(
    sides: tuple[Side, Side], caplog: pytest.LogCaptureFixture
) -> None:
    here, there = sides
    got: list[Handle] = []
    there.backend.create_subscription(Handle, "scan", got.append, 5)
    wait_until(lambda: here.knows_audience("/scan"), "the audience")
    publisher = here.backend.create_publisher(Handle, "scan", 1)
    publisher.publish(Handle(threading.Lock()))
    publisher.publish(Handle(7))
    spin(there, lambda: got)
    assert got == [Handle(7)]
    assert "cannot send message /scan: TypeError: cannot pickle" in caplog.text


def test_a_message_with_a_view_arrives_with_the_same_numbers_in_a_buffer_that_is_read_only(
    sides: tuple[Side, Side],
) -> None:
    here, there = sides
    got: list[Image] = []
    there.backend.create_subscription(Image, "image", got.append, 1)
    wait_until(lambda: here.knows_audience("/image"), "the audience")
    image = Image(data=memoryview(bytearray(b"pixels" * 100_000)).toreadonly())
    here.backend.create_publisher(Image, "image", 1).publish(image)
    spin(there, lambda: got)
    assert got == [image]
    assert isinstance(got[0].data, memoryview)
    assert got[0].data.readonly
    assert here.records == there.records == []


def test_a_deeper_subscription_deepens_the_link(sides: tuple[Side, Side]) -> None:
    here, there = sides
    there.backend.create_subscription(Imu, "imu", print, 3)
    wait_until(lambda: here.knows_audience("/imu"), "the audience")
    there.backend.create_subscription(Imu, "imu", print, 9)
    wait_until(lambda: here.bus._topics["/imu"].subscriptions[0].depth == 9, "the depth")
    assert len(here.bus._topics["/imu"].subscriptions) == 1


def test_records_arrive_with_their_level(sides: tuple[Side, Side]) -> None:
    here, there = sides
    here.link.send_record(30, "hot")
    here.link.send_record(10, "warm", is_chosen=True)
    expected = [(30, "hot", False), (10, "warm", True)]
    wait_until(lambda: there.records == expected, "the records")


def test_the_end_of_the_other_process_ends_the_audience(sides: tuple[Side, Side]) -> None:
    here, there = sides
    there.backend.create_subscription(Header, "scan", print, 1)
    wait_until(lambda: here.knows_audience("/scan"), "the audience")
    there.link.close()
    here.link.close()
    assert not here.knows_audience("/scan")
    here.backend.create_publisher(Header, "scan", 1).publish(Header())


@pytest.fixture
def children() -> Iterator[tuple[Side, Side]]:
    """Two sides that know each other by way of a third."""
    hub = Bus()
    links: list[Link] = []
    sides: list[Side] = []
    for name in ("a", "b"):
        ends = socket.socketpair()
        sides.append(Side(ends[0], name))
        connection: Connection[Any, Any] = Connection(ends[1].detach())
        links += [sides[-1].link, Link(hub, connection, name)]
    for link in links:
        link.start()
    yield sides[0], sides[1]
    for link in links:
        link.close()
    for side in sides:
        side.backend.close()


def test_between_two_children_a_deeper_subscription_is_deepened_all_the_way(
    children: tuple[Side, Side],
) -> None:
    a, b = children
    b.backend.create_subscription(Vector3, "scan", print, 1)
    wait_until(lambda: a.knows_audience("/scan"), "the audience")
    b.backend.create_subscription(Vector3, "scan", print, 1000)
    wait_until(lambda: a.bus._topics["/scan"].subscriptions[0].depth == 1000, "the depth")


def publish(publisher: Publisher[Any], *numbers: int) -> None:
    for number in numbers:
        publisher.publish(Vector3(x=float(number)))


@pytest.mark.parametrize("pair", ["sides", "children"])
def test_each_late_latched_subscription_gets_what_was_kept_once_and_in_order(
    pair: str, request: pytest.FixtureRequest
) -> None:
    here, there = request.getfixturevalue(pair)
    publisher = here.backend.create_publisher(Vector3, "map", LATCHED)
    publish(publisher, 1, 2, 3, 4)
    late = there.subscribe("map", LATCHED)
    spin(there, lambda: len(late) == 3)
    later, volatile = there.subscribe("map", ALL), there.subscribe("map", 10)
    spin(there, lambda: len(later) == 3)
    # Two of the same kind, and one that came before, do not disturb each other.
    wait_until(lambda: len(here.bus._topics["/map"].subscriptions) == 3, "the audience")
    publish(publisher, 5)
    spin(there, lambda: volatile and len(late) == 4 and len(later) == 4)
    assert late == later == [2, 3, 4, 5]
    assert volatile == [5]


def test_nothing_is_lost_or_twice_for_who_comes_from_there_while_somebody_publishes(
    sides: tuple[Side, Side],
) -> None:
    here, there = sides
    publisher = here.backend.create_publisher(Vector3, "map", LATCHED)
    ending = threading.Event()
    sent: list[int] = []

    def publish_on() -> None:
        while not ending.wait(0.0001):
            publish(publisher, len(sent))
            sent.append(len(sent))

    thread = threading.Thread(target=publish_on)
    thread.start()
    try:
        late = []
        for _ in range(10):
            late.append(there.subscribe("map", ALL))
            spin(there, lambda: late[-1])
    finally:
        ending.set()
        thread.join()
    spin(there, lambda: all(got[-1] == len(sent) - 1 for got in late))
    for got in late:
        assert got == list(range(got[0], len(sent)))


def test_a_latched_subscription_that_ends_leaves_nothing_behind(sides: tuple[Side, Side]) -> None:
    here, there = sides
    here.backend.create_publisher(Vector3, "map", LATCHED)
    subscription = there.backend.create_subscription(Vector3, "map", print, LATCHED)
    wait_until(lambda: here.knows_audience("/map"), "the audience")
    there.backend.destroy_subscription(subscription)
    wait_until(lambda: not here.knows_audience("/map"), "the end of the audience")
    assert not there.link._wanted_here
    assert not here.link._wanted_there


def test_who_does_not_match_gets_nothing_from_there_either_and_one_line_says_why(
    sides: tuple[Side, Side], caplog: pytest.LogCaptureFixture
) -> None:
    here, there = sides
    publisher = here.backend.create_publisher(Vector3, "scan", qos_profile_sensor_data)
    reliable, weak = there.subscribe("scan", 10), there.subscribe("scan", qos_profile_sensor_data)
    wait_until(lambda: len(here.bus._topics["/scan"].subscriptions) == 2, "the audience")
    publish(publisher, 1)
    spin(there, lambda: weak)
    assert (reliable, weak) == ([], [1])
    assert [text for text in caplog.messages if "gets nothing" in text] == [
        "/scan: a subscription gets nothing from a publisher:"
        " it asks for RELIABLE and the publisher offers BEST_EFFORT"
    ]


def test_records_are_bounded_while_the_other_side_is_slow() -> None:
    ends = socket.socketpair()
    here = Side(ends[0], "here")
    here.link.start()
    there: Connection[Any, Any] = Connection(ends[1].detach())
    for number in range(5000):
        here.link.send_record(20, f"{number} {'x' * 500}")
    assert len(here.link._executor.ready) <= 1001
    thread = threading.Thread(target=here.link.close)
    thread.start()
    texts: list[str] = []
    try:
        while True:
            what, *values = there.recv()
            texts += [values[1]] if what == "record" else []
    except EOFError:
        thread.join()
    there.close()
    here.backend.close()
    assert texts[0].startswith("0 x")
    assert any("more records" in text for text in texts)
    assert len(texts) < 5000


def test_what_cannot_be_read_is_reported_and_the_next_message_is_taken(
    caplog: pytest.LogCaptureFixture,
) -> None:
    ends = socket.socketpair()
    here = Side(ends[0], "here")
    here.link.start()
    there: Connection[Any, Any] = Connection(ends[1].detach())
    there.send_bytes(b"junk")
    there.send(("record", 20, "fine", False))
    wait_until(lambda: here.records == [(20, "fine", False)], "the record")
    assert "here: what it sends cannot be read: UnpicklingError" in caplog.text
    there.close()
    here.link.close()
    here.backend.close()


@pytest.mark.parametrize(
    ("junk", "why"),
    [
        (b"\x00\x00\x00\x01x", "what it sends cannot be read: UnpicklingError"),
        (b"\x7f\xff\xff\xff", "it announces a message of more than 268435456 bytes"),
    ],
)
def test_whoever_asks_is_told_what_cannot_be_read_and_nothing_more_is_taken(
    junk: bytes, why: str
) -> None:
    ends = socket.socketpair()
    faults: list[str] = []
    records: list[tuple[int, str, bool]] = []
    connection: Connection[Any, Any] = Connection(ends[0].detach())
    link = Link(Bus(), connection, "here", lambda *record: records.append(record), faults.append)
    link.start()
    with ends[1]:
        ends[1].sendall(junk)
        wait_until(lambda: faults, "the reason")
        there: Connection[Any, Any] = Connection(ends[1].detach())
        there.send(("record", 20, "late", False))
        link.close()
        there.close()
    assert [fault.startswith(why) for fault in faults] == [True]
    assert not records


def test_a_message_that_is_too_large_is_reported_and_the_rest_goes_on(
    sides: tuple[Side, Side], caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rosbase.local.link._MOST_BYTES", 10_000)
    here, there = sides
    here.link.send_record(20, "x" * 20_000)
    here.link.send_record(20, "fine")
    wait_until(lambda: there.records == [(20, "fine", False)], "the record")
    assert "here: cannot send a message of 20" in caplog.text


def test_errors_have_room_when_others_are_left_out() -> None:
    ends = socket.socketpair()
    here = Side(ends[0], "here")
    here.link.start()
    there: Connection[Any, Any] = Connection(ends[1].detach())
    for _ in range(5000):
        here.link.send_record(20, "x" * 500)
    here.link.send_record(40, "bad end")
    thread = threading.Thread(target=here.link.close)
    thread.start()
    texts: list[str] = []
    try:
        while True:
            what, *values = there.recv()
            texts += [values[1]] if what == "record" else []
    except EOFError:
        thread.join()
    there.close()
    here.backend.close()
    assert texts[-1].startswith("bad end")
