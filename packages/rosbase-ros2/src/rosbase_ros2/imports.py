"""Says in one line what is missing, where rclpy cannot be imported."""

import os
import subprocess
import sys

from rosbase import NotInstalledError

__all__ = ["NO_SUCH_MIDDLEWARE", "check_rclpy", "explain", "no_such_middleware"]

NO_SUCH_MIDDLEWARE = 102
"""The status with which rcl ends the process (rmw_implementation_identifier_check.c)."""


def check_rclpy() -> None:
    """Imports rclpy, and with it its middleware.

    Raises:
        NotInstalledError: One of them is missing or was made for another Python; the line says
            what to install.
    """
    _check_middleware()
    try:
        import rclpy  # noqa: F401, PLC0415 - only to see whether it can be
    except Exception as error:
        raise NotInstalledError(explain(error)) from error


def _check_middleware() -> None:
    name = os.environ.get("RMW_IMPLEMENTATION")
    if not name:
        return
    # Importing rclpy ends the process, if it has not the middleware that is named.
    command = [sys.executable, "-P", "-c", "import rclpy"]
    if subprocess.run(command, capture_output=True, check=False).returncode == NO_SUCH_MIDDLEWARE:
        raise NotInstalledError(f"{no_such_middleware(name)}: install it, or unset the variable")


def no_such_middleware(name: str) -> str:
    """What is wrong where that middleware is named."""
    return f"RMW_IMPLEMENTATION is {name}, which this rclpy does not have"


def explain(error: Exception) -> str:
    """Why rclpy cannot be imported, in one line."""
    if isinstance(error, ModuleNotFoundError) and error.name == "rclpy":
        return "rclpy is not installed: pip install 'ros-jazzy-rclpy[fastrtps]'"
    reason = (str(error).splitlines() or [type(error).__name__])[0]
    # `ros-jazzy-rclpy` alone looks like this.
    if "librmw" in reason:
        return f"rclpy finds no middleware: pip install 'ros-jazzy-rclpy[fastrtps]' ({reason})"
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return f"rclpy cannot be imported by Python {python}; was it built for another one? ({reason})"
