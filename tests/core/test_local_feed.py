"""A topic that a recording publishes in place of the program."""

import pytest

from rosbase import Backend, BackendOptions
from rosbase.errors import BackendError
from rosbase.local.backend import LocalBackend
from rosbase.local.bus import Bus
from rosbase.messages import Header, Imu, Time
from rosbase.qos import DurabilityPolicy, QoSProfile
from rosbase.testing import virtual_backend

LATCHED = QoSProfile(2, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def heard(name: str) -> Header:
    return Header(Time(), name)


def test_publishers_of_the_program_reach_nobody_and_the_recording_reaches_all() -> None:
    backend = virtual_backend()
    got: list[str] = []
    early = backend.create_publisher(Header, "scan", LATCHED)
    early.publish(heard("kept"))
    backend.create_subscription(Header, "scan", lambda message: got.append(message.frame_id), 10)
    backend.create_subscription(
        Header, "scan", lambda message: got.append(f"latched {message.frame_id}"), LATCHED
    )
    feed = backend.take_over("/scan")
    late = backend.create_publisher(Header, "scan", 10)
    backend.create_subscription(
        Header, "scan", lambda message: got.append(f"late {message.frame_id}"), LATCHED
    )
    tapped: list[str] = []
    backend.add_tap("/scan", lambda message: tapped.append(message.frame_id))
    for publisher in (early, late):
        publisher.publish(heard("own"))
    feed(heard("recorded"))
    while backend.spin_once(0.0):
        pass
    # The first was there before the recording took over.
    assert sorted(got) == ["latched kept", "latched recorded", "late recorded", "recorded"]
    assert tapped == ["recorded"]
    assert backend.kept_messages("/scan") == []
    backend.close()


def test_what_is_kept_comes_to_later_subscriptions_that_ask() -> None:
    backend = virtual_backend()
    feed = backend.take_over("/tf_static", depth=3)
    for name in "abcd":
        feed(heard(name))
    got: list[str] = []
    backend.create_subscription(
        Header, "tf_static", lambda message: got.append(message.frame_id), LATCHED
    )
    backend.create_subscription(Header, "tf_static", lambda message: got.append("volatile"), 10)
    while backend.spin_once(0.0):
        pass
    assert got == ["c", "d"]
    assert [message.frame_id for message in backend.kept_messages("/tf_static")] == ["b", "c", "d"]
    backend.close()


def test_a_message_of_another_type_is_refused() -> None:
    backend = virtual_backend()
    feed = backend.take_over("/scan")
    backend.create_subscription(Header, "scan", print, 10)
    with pytest.raises(TypeError, match="/scan takes Header, not Imu"):
        feed(Imu())
    backend.close()


def test_other_backends_say_that_they_cannot() -> None:
    backend = virtual_backend()
    with pytest.raises(BackendError, match="/scan: messages cannot be replayed"):
        Backend.take_over(backend, "/scan")
    backend.close()


def test_the_topic_is_the_programs_again_when_the_backend_is_closed() -> None:
    bus = Bus()
    first, second = (LocalBackend(BackendOptions(node_name=name), bus) for name in ("one", "two"))
    feed = first.take_over("/scan", depth=1)
    feed(heard("recorded"))
    first.close()
    feed(heard("late"))  # nobody hears it
    got: list[str] = []
    second.create_subscription(Header, "scan", lambda message: got.append(message.frame_id), 10)
    second.create_publisher(Header, "scan", 10).publish(heard("own"))
    while second.spin_once(0.0):
        pass
    assert got == ["own"]
    second.close()
