"""Samples of an IMU on their way out: what is the same in all of them is prepared once."""

from collections.abc import Callable, Sequence
from typing import TypeAlias

from rosbase.messages import Header, Imu, Quaternion, Time, Vector3

__all__ = ["ImuSender", "message_sender"]

ImuSender: TypeAlias = Callable[[int, Sequence[float], Sequence[float], Sequence[float]], object]
"""`send(stamp_ns, orientation, angular_velocity, linear_acceleration)`: publishes one sample.

It returns False if the world did not take the sample, as `Publisher.publish` does.

The stamp is in nanoseconds since the epoch and fits into a ROS stamp (`rosbase.messages.is_stamp`).
Orientation is x, y, z, w of a unit quaternion, the others are x, y, z in rad/s and m/s^2. All are
finite floats, because the caller has checked them, so nobody need check again.
"""


def message_sender(publish: Callable[[Imu], object], template: Imu) -> ImuSender:
    """What publishes a message for each sample; frame and covariances are the template's."""
    frame_id = template.header.frame_id
    of_orientation = template.orientation_covariance
    of_velocity = template.angular_velocity_covariance
    of_acceleration = template.linear_acceleration_covariance

    def send(
        stamp_ns: int,
        orientation: Sequence[float],
        angular_velocity: Sequence[float],
        linear_acceleration: Sequence[float],
    ) -> object:
        return publish(
            Imu(
                Header(Time.from_nanoseconds(stamp_ns), frame_id),
                Quaternion(*orientation),
                of_orientation,
                Vector3(*angular_velocity),
                of_velocity,
                Vector3(*linear_acceleration),
                of_acceleration,
            )
        )

    return send
