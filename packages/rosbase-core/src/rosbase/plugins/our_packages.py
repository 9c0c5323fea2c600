"""The packages of this project: the names that belong to each, and how to install it."""

from rosbase.plugins.discovery import CORE

__all__ = ["OURS", "how_to_install"]

OURS = {
    ("backend", "local"): CORE,
    ("backend", "ros2"): "rosbase-ros2",
    ("check", "mqtt"): "imu-mqtt",
    ("check", "ros2"): "rosbase-ros2",
    ("check", "serial"): "imu-serial",
    ("command", "view"): "rosbase-view",
    ("recorder", "mcap"): "rosbase-mcap",
    ("transport", "mqtt"): "imu-mqtt",
    ("transport", "serial"): "imu-serial",
}
"""Package that provides a name, by kind and name."""


def how_to_install(package: str) -> str:
    """Return the commands that install a package of this project, and where each works."""
    return (
        f"in a clone of rosbase: pip install ./packages/{package};"
        f" from an index that has it (PyPI does not yet): pip install {package}"
    )
