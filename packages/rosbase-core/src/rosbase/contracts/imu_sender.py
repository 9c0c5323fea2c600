"""IMU senders: publish samples, and prepare once the parts that all samples share."""

from collections.abc import Callable, Sequence
from typing import TypeAlias

from rosbase.messages import Header, Imu, Quaternion, Time, Vector3

__all__ = ["ImuSender", "message_sender"]

ImuSender: TypeAlias = Callable[[int, Sequence[float], Sequence[float], Sequence[float]], object]
"""`send(stamp_ns, orientation, angular_velocity, linear_acceleration)`: publishes one sample.

It returns False if the backend did not take the sample, as `Publisher.publish` does.

The stamp is in nanoseconds since the epoch and fits into a ROS stamp
(`rosbase.messages.is_stamp`). Orientation is x, y, z, w of a unit quaternion, the others are x, y,
z in rad/s and m/s^2. All are finite floats: the caller has checked them, so the sender need not
check again.
"""


def message_sender(publish: Callable[[Imu], object], template: Imu) -> ImuSender:
    """Return a sender that publishes a message per sample.

    Frame and covariances are those of the template.
    """
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
