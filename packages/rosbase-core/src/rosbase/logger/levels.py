"""Log levels: the numbers of `logging`, which are also ROS's, and the names of ROS."""

import logging

__all__ = ["LEVELS", "level_named", "level_number", "message_level", "severity"]

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
    number = level_named(level)
    if number is None:
        raise ValueError(f"no log level is called {level!r}: {', '.join(LEVELS).lower()}")
    return number


def message_level(level: str | int) -> int:
    """Return the number of the level of a message. Unlike a limit, it must be a known one.

    Raises:
        ValueError: There is no such level. Most likely it is a value to be filled in.
    """
    if isinstance(level, str):
        number = level_number(level)
    else:
        number = int(level) if isinstance(level, int) and not isinstance(level, bool) else 0
    if number == logging.NOTSET or not _is_known(number):
        raise ValueError(
            f"{level!r} is no log level ({', '.join(LEVELS).lower()}); "
            "this method formats no arguments, so use an f-string: f'... {value}'"
        )
    return number


def level_named(name: str) -> int | None:
    """Return the number of the level of that name, in any case; None if there is none."""
    # For a name that `logging` knows, its `getLevelName` returns the number.
    number: object = LEVELS.get(name.upper()) or logging.getLevelName(name.upper())
    return number if isinstance(number, int) else None


def _is_known(number: int) -> bool:
    return logging.getLevelName(number) != f"Level {number}"


def severity(level: int) -> str:
    """Return the ROS name of the nearest level that is not above this one."""
    return _NAMES[min(logging.CRITICAL, max(logging.DEBUG, level // 10 * 10))]
