"""Explain in one line what is missing if rclpy cannot be imported."""

import os
import signal
import subprocess
import sys

from rosbase import ConfigurationError, NotInstalledError
from rosbase_ros2.machine import SHARED_MEMORY, free_bytes

__all__ = [
    "NO_SHARED_MEMORY",
    "NO_SUCH_MIDDLEWARE",
    "check_rclpy",
    "explain",
    "memory_is_full",
    "no_such_middleware",
    "python_command",
]

NO_SUCH_MIDDLEWARE = 102
"""Exit status with which rcl ends the process (rmw_implementation_identifier_check.c)."""

NO_SHARED_MEMORY = -signal.SIGBUS
"""Exit status of a process that wrote to shared memory when it was full."""

# LTTng, which rcl traces with, writes a page there when rclpy is imported.
_FULL_BYTES = 2**16


def check_rclpy() -> None:
    """Import rclpy, and with it its middleware.

    Raises:
        NotInstalledError: One of them is missing or was made for another Python; the message says
            what to install.
        ConfigurationError: Shared memory is full, so that importing rclpy would end the process.
    """
    named = os.environ.get("RMW_IMPLEMENTATION")
    free = free_bytes()
    if named or free < _FULL_BYTES:
        _import_elsewhere(named or "", free)
    try:
        import rclpy  # noqa: F401, PLC0415 - only to see whether it can be
    except Exception as error:
        raise NotInstalledError(explain(error)) from error


def _import_elsewhere(named: str, free: int) -> None:
    """Import rclpy in a child process, where it may end the process."""
    command = python_command("import rclpy")
    status = subprocess.run(command, capture_output=True, check=False).returncode
    if named and status == NO_SUCH_MIDDLEWARE:
        raise NotInstalledError(f"{no_such_middleware(named)}: install it, or unset the variable")
    if status == NO_SHARED_MEMORY:
        raise ConfigurationError(f"ROS 2 does not start: {memory_is_full(free)}")


def python_command(code: str) -> list[str]:
    """Return the command that runs the code, and imports nothing from the working directory.

    Python's option `-P` does the same, but not on 3.10.
    """
    return [sys.executable, "-c", f"import sys; sys.path[:] = filter(None, sys.path); {code}"]


def memory_is_full(free: int) -> str:
    """Return the fault if so few bytes of shared memory are left."""
    return (
        f"{SHARED_MEMORY} is full ({free} bytes left), and rclpy writes there when it is imported;"
        " free some: fastdds shm clean"
    )


def no_such_middleware(name: str) -> str:
    """Return the message if the named middleware is missing."""
    return f"RMW_IMPLEMENTATION is {name}, which this rclpy does not have"


def explain(error: Exception) -> str:
    """Return why rclpy cannot be imported, in one line."""
    if isinstance(error, ModuleNotFoundError) and error.name == "rclpy":
        return "rclpy is not installed: pip install 'ros-jazzy-rclpy[fastrtps]'"
    reason = (str(error).splitlines() or [type(error).__name__])[0]
    # `ros-jazzy-rclpy` alone looks like this.
    if "librmw" in reason:
        return f"rclpy finds no middleware: pip install 'ros-jazzy-rclpy[fastrtps]' ({reason})"
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return f"rclpy cannot be imported by Python {python}; was it built for another one? ({reason})"
