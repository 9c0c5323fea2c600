"""An orientation as angles, for people to read."""

from math import asin, atan2

from rosbase.messages import Quaternion

__all__ = ["roll_pitch_yaw"]


def roll_pitch_yaw(q: Quaternion) -> tuple[float, float, float]:
    """Return the angles about x'', y' and z in rad, of a quaternion of any length but 0.

    The order is yaw, pitch, roll, as in REP-103 (Diebel, "Representing Attitude", 2006, eq.
    290). Pitch is from -pi/2 to pi/2, the others from -pi to pi. At a pitch of a quarter turn,
    only the difference of roll and yaw is known.
    """
    x, y, z, w = q.x, q.y, q.z, q.w
    square = x * x + y * y + z * z + w * w
    return (
        atan2(2.0 * (w * x + y * z), square - 2.0 * (x * x + y * y)),
        asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x) / square))),
        atan2(2.0 * (w * z + x * y), square - 2.0 * (y * y + z * z)),
    )
