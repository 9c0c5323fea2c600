"""The frames of a camera: its body's, and its optical one (REP-103)."""

from collections.abc import Sequence
from typing import Any, overload

from rosbase.utils.vectors import VectorMessage, maths_for, numbers_of

__all__ = ["trans_opt_to_ros_frame", "trans_ros_frame_to_opt_frame"]


@overload
def trans_ros_frame_to_opt_frame(
    vector: Sequence[float] | VectorMessage,
) -> tuple[float, float, float]: ...
@overload
def trans_ros_frame_to_opt_frame(vector: Any) -> Any: ...
def trans_ros_frame_to_opt_frame(vector: Any) -> Any:
    """Return a vector in the optical frame of a camera.

    The frame of ROS has x forward, y left and z up. The optical one has x right, y down and z
    forward (REP-103, "Suffix Frames").

    Args:
        vector: In the frame of ROS: a list, a tuple, a message such as `Vector3` or `Point`, or an
            array of numpy whose last axis is the vector.

    Returns:
        A tuple, or an array if an array is given.

    Raises:
        ValueError: It has not three numbers.
    """
    x, y, z = numbers_of(vector, "xyz")
    return maths_for(vector).join((-y, -z, x))


@overload
def trans_opt_to_ros_frame(
    vector: Sequence[float] | VectorMessage,
) -> tuple[float, float, float]: ...
@overload
def trans_opt_to_ros_frame(vector: Any) -> Any: ...
def trans_opt_to_ros_frame(vector: Any) -> Any:
    """Return a vector in the frame of ROS: the inverse of `trans_ros_frame_to_opt_frame`.

    Args:
        vector: In the optical frame of a camera, as there.

    Returns:
        A tuple, or an array if an array is given.

    Raises:
        ValueError: It has not three numbers.
    """
    x, y, z = numbers_of(vector, "xyz")
    return maths_for(vector).join((z, -x, -y))
