"""Topics of the local backend, beside what every backend promises (test_local_contract.py)."""

import gc
import weakref

from hypothesis import given
from hypothesis import strategies as st

from rosbase.messages import Header, Time
from rosbase.qos import DurabilityPolicy, HistoryPolicy, QoSProfile
from rosbase.testing import virtual_backend


@given(st.integers(1, 20), st.integers(0, 50))
def test_a_subscription_keeps_the_last_ones_and_counts_the_others(depth: int, sent: int) -> None:
    backend = virtual_backend()
    got: list[Header] = []
    subscription = backend.create_subscription(Header, "scan", got.append, depth)
    publisher = backend.create_publisher(Header, "scan", 1)
    for number in range(sent):
        publisher.publish(Header(Time(number)))
    while backend.spin_once(0.0):
        pass
    assert [header.stamp.sec for header in got] == list(range(sent))[-depth:]
    assert subscription.dropped == max(0, sent - depth)
    backend.close()


def test_a_topic_is_forgotten_with_its_last_user() -> None:
    backend = virtual_backend()
    publisher = backend.create_publisher(Header, "scan", 1)
    backend.destroy_publisher(publisher)
    backend.create_publisher(Time, "scan", 1)
    backend.close()


def test_a_publisher_that_has_ended_keeps_nothing_whoever_goes_on_publishing() -> None:
    backend = virtual_backend()
    profile = QoSProfile(
        history=HistoryPolicy.KEEP_ALL, durability=DurabilityPolicy.TRANSIENT_LOCAL
    )
    publisher = backend.create_publisher(Header, "scan", profile)
    backend.destroy_publisher(publisher)
    message = Header()
    reference = weakref.ref(message)
    publisher.publish(message)
    del message
    gc.collect()
    assert reference() is None
    backend.close()
