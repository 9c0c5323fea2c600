"""Utilities with the names that programs written for ros_base import from `ros_base.utils`.

Each name is imported when it is first used. None of them needs numpy; those that take vectors give
arrays back if they get arrays.
"""

from typing import TYPE_CHECKING

from rosbase.messages.lazy import names_of, on_demand

if TYPE_CHECKING:
    from rosbase.utils.angles import warp2pi
    from rosbase.utils.circular_buffer import CircularBuffer
    from rosbase.utils.custom_logger import CustomLogger
    from rosbase.utils.debugging import add_debug_mode
    from rosbase.utils.frames import trans_opt_to_ros_frame, trans_ros_frame_to_opt_frame
    from rosbase.utils.latency import profile_latency
    from rosbase.utils.low_pass import VectorLPFilter
    from rosbase.utils.rotations import quat_rotate_inverse, quat_to_rpy, rpy_to_quat
else:
    __getattr__ = on_demand(
        __name__,
        {
            "CircularBuffer": "circular_buffer",
            "CustomLogger": "custom_logger",
            "VectorLPFilter": "low_pass",
            "add_debug_mode": "debugging",
            "profile_latency": "latency",
            "quat_rotate_inverse": "rotations",
            "quat_to_rpy": "rotations",
            "rpy_to_quat": "rotations",
            "trans_opt_to_ros_frame": "frames",
            "trans_ros_frame_to_opt_frame": "frames",
            "warp2pi": "angles",
        },
        __name__,
    )

__all__ = [
    "CircularBuffer",
    "CustomLogger",
    "VectorLPFilter",
    "add_debug_mode",
    "profile_latency",
    "quat_rotate_inverse",
    "quat_to_rpy",
    "rpy_to_quat",
    "trans_opt_to_ros_frame",
    "trans_ros_frame_to_opt_frame",
    "warp2pi",
]

__dir__ = names_of(__all__)
