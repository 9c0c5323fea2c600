"""Registers the backend `ros2`. Imports rclpy only when it is chosen."""

from collections.abc import Iterable

from rosbase.backend import Backend, BackendOptions
from rosbase.plugins import BackendPlugin, hookimpl

__all__ = ["rosbase_backends"]


def _create(options: BackendOptions) -> Backend:
    from rosbase_ros2.imports import check_rclpy

    check_rclpy()
    from rosbase_ros2.backend import Ros2Backend

    return Ros2Backend(options)


@hookimpl
def rosbase_backends() -> Iterable[BackendPlugin]:
    """The backend on rclpy."""
    yield BackendPlugin("ros2", "a ROS 2 node, by rclpy", _create, arguments_after="--ros-args")
