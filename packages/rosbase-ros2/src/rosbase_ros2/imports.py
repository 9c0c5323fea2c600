"""Says in one line what is missing, where rclpy cannot be imported."""

import sys

from rosbase.errors import NotInstalledError

__all__ = ["check_rclpy"]


def check_rclpy() -> None:
    """Imports rclpy and its middleware.

    Raises:
        NotInstalledError: One of them is missing or was made for another Python; the line says
            what to install.
    """
    try:
        import rclpy  # noqa: PLC0415
    except ModuleNotFoundError as error:
        if error.name and error.name.split(".")[0] == "rclpy":
            raise NotInstalledError(
                "rclpy is not installed: pip install rosbase-ros2, or source a ROS 2 workspace"
            ) from error
        raise _broken(error) from error
    except Exception as error:
        raise _broken(error) from error
    try:
        rclpy.get_rmw_implementation_identifier()
    except Exception as error:
        raise NotInstalledError(
            "rclpy finds no middleware: pip install 'ros-jazzy-rclpy[fastrtps]'"
            f" ({_first_line(error)})"
        ) from error


def _broken(error: BaseException) -> NotInstalledError:
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return NotInstalledError(
        f"rclpy cannot be imported by this Python {python}: was it built for another one?"
        f" ({_first_line(error)})"
    )


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
