"""The outlet prepares what samples need before the first one comes."""

from typing import Any

import pytest

from rosbase.imu.counts import Counts
from rosbase.imu.mapping import GROUPS, Sample
from rosbase.imu.outlet import Outlet, Publishers
from rosbase.messages import COVARIANCE_NOT_REPORTED, COVARIANCE_UNKNOWN, Imu

ORIENTATION, VECTOR = (0.0, 0.0, 0.0, 1.0), (1.0, 2.0, 3.0)


class Publisher:
    """A publisher that is always enabled."""

    is_enabled = True

    def __init__(self, topic: str) -> None:
        self.topic = topic


class Desk:
    """Notes the templates that are prepared, and the values that are sent."""

    def __init__(self, mapped: tuple[str, ...]) -> None:
        self.prepared: list[tuple[str, Imu]] = []
        self.sent: list[tuple[Any, ...]] = []
        covariances = dict.fromkeys(GROUPS, COVARIANCE_UNKNOWN)
        publishers = Publishers(self.create, "imu")
        self.outlet = Outlet(publishers, self.prepare, "frame", covariances, Counts(), mapped)

    def create(self, msg_type: type, topic: str) -> Any:
        return Publisher(topic)

    def prepare(self, publisher: Any, template: Imu) -> Any:
        self.prepared.append((publisher.topic, template))
        return lambda *values: self.sent.append(values)


@pytest.mark.parametrize(
    ("mapped", "topic"),
    [
        (GROUPS, "imu/data"),
        (("orientation",), "imu/data"),
        (("angular_velocity", "linear_acceleration"), "imu/data_raw"),
    ],
)
def test_the_sender_is_prepared_before_the_first_sample(
    mapped: tuple[str, ...], topic: str
) -> None:
    desk = Desk(mapped)
    [(prepared, template)] = desk.prepared
    assert prepared == topic
    is_reported = template.angular_velocity_covariance != COVARIANCE_NOT_REPORTED
    assert is_reported == ("angular_velocity" in mapped)
    sample = Sample(
        orientation=ORIENTATION if "orientation" in mapped else None,
        angular_velocity=VECTOR if "angular_velocity" in mapped else None,
        linear_acceleration=VECTOR if "linear_acceleration" in mapped else None,
        magnetic_field=None,
        device_time_ns=None,
    )
    assert desk.outlet.publish(sample, 5)
    assert len(desk.sent) == len(desk.prepared) == 1


def test_the_sender_of_samples_that_lack_something_is_prepared_once_one_comes() -> None:
    desk = Desk(GROUPS)
    for _ in range(2):
        assert desk.outlet.publish(Sample(None, VECTOR, VECTOR, None, None), 5)
    assert [topic for topic, _ in desk.prepared] == ["imu/data", "imu/data_raw"]


def test_nothing_is_prepared_for_a_device_that_measures_the_magnetic_field_only() -> None:
    assert Desk(("magnetic_field",)).prepared == []
