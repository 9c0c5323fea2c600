"""Register the backend `ros2`, and its check. Imports rclpy only when it is chosen."""

from collections.abc import Iterable
from typing import Any

from rosbase import (
    Backend,
    BackendOptions,
    BackendPlugin,
    CheckContext,
    CheckPlugin,
    Finding,
    MessageFormat,
    hookimpl,
)

__all__ = ["rosbase_backends", "rosbase_checks"]


def _create(options: BackendOptions) -> Backend:
    from rosbase_ros2.imports import check_rclpy

    check_rclpy()
    from rosbase_ros2.backend import Ros2Backend

    return Ros2Backend(options)


def _message_format(msg_type: Any) -> MessageFormat:
    from rosbase_ros2.formats import plugin_conversions, written_format

    return written_format(msg_type, plugin_conversions())


def _check(context: CheckContext) -> Iterable[Finding]:
    from rosbase_ros2.check import check_ros

    return check_ros()


@hookimpl
def rosbase_backends() -> Iterable[BackendPlugin]:
    """Return the backend on rclpy."""
    yield BackendPlugin(
        "ros2",
        "a ROS 2 node, by rclpy",
        _create,
        arguments_after="--ros-args",
        message_format=_message_format,
    )


@hookimpl
def rosbase_checks() -> Iterable[CheckPlugin]:
    """Return the check of ROS on this machine."""
    yield CheckPlugin("ros2", "rclpy, its middleware and the domain", _check)
