"""The orientation of an Imu as a transform: no viewer turns a board by the Imu itself. Pure."""

import math
from collections.abc import Collection

from rosbase import WireError
from rosbase.messages import Header, Imu, Quaternion, Transform, TransformStamped
from rosbase.messages.tf2_msgs import TFMessage
from rosbase.wire import deserialize, serialize
from rosbase_view.reports import TopicKey

__all__ = ["TF", "TF_TYPE", "WORLD", "Transforms"]

TF = "/tf"
TF_TYPE = "tf2_msgs/msg/TFMessage"
WORLD = "world"
"""Frame in which orientations are: x is east, y is north and z is up, as REP 103 says."""


class Transforms:
    """Makes transforms from the frame of an Imu to the world."""

    def __init__(self) -> None:
        """Begin with no frames."""
        self._owners: dict[str, TopicKey] = {}

    def keep(self, topics: Collection[TopicKey]) -> None:
        """Forget the frames of topics that have gone."""
        self._owners = {frame: topic for frame, topic in self._owners.items() if topic in topics}

    def of(self, topic: TopicKey, data: bytes) -> bytes | None:
        """Return a TFMessage for an Imu, both as CDR.

        None if the Imu has no orientation, or if another topic has turned its frame already.
        """
        try:
            imu = deserialize(data, Imu)
        except WireError:
            return None
        rotation = _unit(imu.orientation)
        # A first element of -1 says that there is none.
        if rotation is None or imu.orientation_covariance[0] == -1.0:
            return None
        frame = imu.header.frame_id or topic[0].strip("/")
        if self._owners.setdefault(frame, topic) != topic:
            return None
        header = Header(imu.header.stamp, WORLD)
        stamped = TransformStamped(header, frame, Transform(rotation=rotation))
        return bytes(serialize(TFMessage((stamped,))))


def _unit(found: Quaternion) -> Quaternion | None:
    """Return the quaternion with norm 1; None if it is no rotation."""
    parts = found.x, found.y, found.z, found.w
    norm = math.hypot(*parts)
    if norm == 0.0 or not math.isfinite(norm):
        return None
    return Quaternion(*(part / norm for part in parts))
