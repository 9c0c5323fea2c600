"""Log levels: the numbers of `logging`, which are also ROS's, and the names of ROS."""

import logging

__all__ = ["LEVELS", "level_number", "severity"]

LEVELS = {
    "DEBUG": logging.DEBUG,
    "INFO": logging.INFO,
    "WARN": logging.WARNING,
    "ERROR": logging.ERROR,
    "FATAL": logging.CRITICAL,
}
"""Names of the levels in ROS."""

_NAMES = {number: name for name, number in LEVELS.items()}


def level_number(level: str | int) -> int:
    """Return the number of a level: `"WARN"`, `"warning"`, `logging.WARNING`, or rclpy's severity.

    Raises:
        ValueError: No level has that name.
    """
    if not isinstance(level, str):
        return int(level)
    known = {**logging.getLevelNamesMapping(), **LEVELS}
    number = known.get(level.upper())
    if number is None:
        raise ValueError(f"no log level is called {level!r}: {', '.join(LEVELS).lower()}")
    return number


def severity(level: int) -> str:
    """Return the ROS name of the nearest level that is not above this one."""
    return _NAMES[min(logging.CRITICAL, max(logging.DEBUG, level // 10 * 10))]
