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
        self.prepared: list[tuple[str, Any]] = []
        self.sent: list[tuple[Any, ...]] = []
        covariances = dict.fromkeys(GROUPS, COVARIANCE_UNKNOWN)
        publishers = Publishers(self.create, "imu")
        self.outlet = Outlet(publishers, self.prepare, "frame", covariances, Counts(), mapped)

    def create(self, msg_type: type, topic: str) -> Any:
        return Publisher(topic)

    def prepare(self, publisher: Any, template: Any, varying: Any) -> Any:
        self.prepared.append((publisher.topic, template))
        return lambda *values: self.sent.append(values)

    def topics(self) -> list[str]:
        return [topic for topic, _ in self.prepared]


def sample_of(*quantities: str) -> Sample:
    """A sample that has these quantities."""
    return Sample(
        orientation=ORIENTATION if "orientation" in quantities else None,
        angular_velocity=VECTOR if "angular_velocity" in quantities else None,
        linear_acceleration=VECTOR if "linear_acceleration" in quantities else None,
        magnetic_field=VECTOR if "magnetic_field" in quantities else None,
        device_time_ns=None,
    )


@pytest.mark.parametrize(
    ("mapped", "topics"),
    [
        (GROUPS, ["imu/data", "imu/mag"]),
        (("orientation",), ["imu/data"]),
        (("angular_velocity", "linear_acceleration"), ["imu/data_raw"]),
        (("magnetic_field",), ["imu/mag"]),
    ],
)
def test_the_senders_are_prepared_before_the_first_sample(
    mapped: tuple[str, ...], topics: list[str]
) -> None:
    desk = Desk(mapped)
    assert desk.topics() == topics
    for _, template in desk.prepared:
        if isinstance(template, Imu):
            is_reported = template.angular_velocity_covariance != COVARIANCE_NOT_REPORTED
            assert is_reported == ("angular_velocity" in mapped)
    for _ in range(2):
        assert desk.outlet.publish(sample_of(*mapped), 5)
    assert desk.topics() == topics
    assert len(desk.sent) == 2 * len(topics)


def test_the_sender_of_samples_that_lack_something_is_prepared_once_one_comes() -> None:
    desk = Desk(GROUPS)
    for _ in range(2):
        assert desk.outlet.publish(sample_of("angular_velocity", "linear_acceleration"), 5)
    assert desk.topics() == ["imu/data", "imu/mag", "imu/data_raw"]
