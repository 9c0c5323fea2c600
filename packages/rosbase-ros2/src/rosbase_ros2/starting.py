"""Start an rclpy node, or explain in one line why ROS does not start."""

import os
from collections.abc import Iterable, Mapping
from typing import Any

import rclpy
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import get_rmw_implementation_identifier

from rosbase import (
    BackendError,
    BackendOptions,
    ParameterValue,
    SystemClock,
    date_fault,
    one_line,
)
from rosbase_ros2.machine import (
    date_refusal,
    domain_fault,
    free_bytes,
    memory_fault,
    spare_shared_memory,
)
from rosbase_ros2.shared_node import SharedNode
from rosbase_ros2.written import RosArguments

__all__ = [
    "is_enabled",
    "prepare_machine",
    "ros_arguments",
    "start_node",
    "start_other_node",
    "without_node_name",
]


def prepare_machine() -> str:
    """Check the requirements of ROS on this machine; return a warning in one line, or nothing.

    Raises:
        BackendError: ROS cannot start, and might not say so itself.
    """
    middleware: str = get_rmw_implementation_identifier()
    free = free_bytes()
    fault = (
        domain_fault(os.environ)
        or date_refusal(SystemClock().now_ns(), middleware)
        or memory_fault(os.environ, middleware, free)
    )
    if fault:
        raise _does_not_start(fault)
    return spare_shared_memory(os.environ, middleware, free)


def start_node(context: Any, options: BackendOptions, arguments: RosArguments) -> SharedNode:
    """Return a new rclpy node, in a context that is started with it.

    Args:
        context: The rclpy context.
        options: The options of the backend.
        arguments: The arguments for ROS on the command line.

    Raises:
        BackendError: ROS refuses the arguments or the name.
    """
    try:
        with arguments.for_rcl() as taken:
            rclpy.init(args=taken, context=context, signal_handler_options=SignalHandlerOptions.NO)
        overrides = [
            rclpy.Parameter(name, value=value)
            for name, value in options.parameter_overrides.items()
        ]
        name = options.node_name
        # What the command line calls the manager would else be the name of its children too.
        own = _named(name) if options.is_child else None
        return SharedNode(name, context=context, cli_args=own, parameter_overrides=overrides)
    except Exception as error:
        context.try_shutdown()
        reason = one_line(arguments.named_by_user(str(error)))
        if isinstance(error, rclpy_implementation.UnknownROSArgsError):
            # rclpy has nothing to say but the list of them.
            reason = f"not known behind --ros-args: {reason}"
        elif fault := date_fault(SystemClock().now_ns()):
            reason = f"{fault} ({reason})"
        raise _does_not_start(reason) from error


def start_other_node(
    context: Any, name: str, overrides: Mapping[str, ParameterValue]
) -> SharedNode:
    """Return a new rclpy node beside the first, in the same context and namespace.

    Args:
        context: The rclpy context.
        name: Its name; the command line names the first node only.
        overrides: Values that override the defaults of its parameters.

    Raises:
        BackendError: ROS refuses the name.
    """
    try:
        given = [rclpy.Parameter(key, value=value) for key, value in overrides.items()]
        return SharedNode(name, context=context, cli_args=_named(name), parameter_overrides=given)
    except Exception as error:
        raise BackendError(f"node {name!r} cannot be created: {one_line(str(error))}") from error


def _named(name: str) -> list[str]:
    return ["--ros-args", "-r", f"__node:={name}"]


def without_node_name(words: Iterable[str]) -> list[str]:
    """Return arguments for ROS without a rule that would give every node the same name."""
    found: list[str] = []
    for word in words:
        if word.startswith(("__node:=", "__name:=")) and found[-1:] in (["-r"], ["--remap"]):
            found.pop()
        else:
            found.append(word)
    return found


def ros_arguments(command_line: Iterable[str]) -> list[str]:
    """Return the arguments after `--ros-args`, up to `--` or the end, with these two words.

    Nothing else is for ROS. rcl would take a `name:=value` of the program itself for a
    remapping in the style of ROS 1, apply it, and warn of it.
    """
    found: list[str] = []
    within = False
    for argument in command_line:
        within = within or argument == "--ros-args"
        if within:
            found.append(argument)
        within = within and argument != "--"
    return found


def is_enabled(feature: str, arguments: Iterable[str]) -> bool:
    """Return whether the arguments for ROS leave a feature of its log, such as `stdout-logs`, on.

    The last of `--enable-<feature>` and `--disable-<feature>` counts, as in rcl.
    """
    words = {f"--enable-{feature}": True, f"--disable-{feature}": False}
    said = [words[argument] for argument in arguments if argument in words]
    return said[-1] if said else True


def _does_not_start(reason: str) -> BackendError:
    return BackendError(f"ROS 2 does not start: {reason}")
