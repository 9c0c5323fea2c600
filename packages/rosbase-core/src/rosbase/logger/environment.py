"""Log levels and the log file from the environment."""

import logging
import os

from rosbase.errors import ConfigurationError
from rosbase.logger.levels import level_number
from rosbase.logger.log_file import DEFAULT_FILE_COUNT, DEFAULT_FILE_SIZE, log_to_file
from rosbase.logger.sizes import byte_count
from rosbase.text.printable import printable

__all__ = ["FILE_VARIABLES", "LEVEL_VARIABLE", "apply_environment", "levels_in"]

LEVEL_VARIABLE = "ROSBASE_LOG_LEVEL"
"""Environment variable such as `info,camera:=debug`."""

FILE_VARIABLES = ("ROSBASE_LOG_FILE", "ROSBASE_LOG_FILE_SIZE", "ROSBASE_LOG_FILE_COUNT")
"""Environment variables of the log file: its path, its size as `10 MB`, and how many are kept."""

_applied: list[str] = [""]
_applied_file: list[str] = [""]


def levels_in(text: str) -> list[tuple[str, int]]:
    """Return the name of each logger and its level; the empty name stands for all.

    Raises:
        ConfigurationError: A level has no such name.
    """
    levels = []
    for part in filter(None, map(str.strip, text.split(","))):
        name, _, level = part.rpartition(":=")
        try:
            levels.append((name, level_number(level)))
        except ValueError as error:
            raise ConfigurationError(str(error)) from None
    return levels


def apply_environment() -> None:
    """Set levels and the log file as the environment says, once: a program may change them later.

    Raises:
        ConfigurationError: A level has no such name, or the size or count of files is invalid.
    """
    text = os.environ.get(LEVEL_VARIABLE, "")
    if text != _applied[0]:
        _apply_levels(levels_in(text))
        _applied[0] = text
    path = os.environ.get(FILE_VARIABLES[0], "")
    if path != _applied_file[0]:
        _apply_file(path)
        _applied_file[0] = path


def _apply_levels(levels: list[tuple[str, int]]) -> None:
    ours = logging.getLogger("rosbase")
    for name, level in levels:
        (ours.getChild(name) if name else ours).setLevel(level)


def _apply_file(path: str) -> None:
    _, size_name, count_name = FILE_VARIABLES
    size = os.environ.get(size_name) or DEFAULT_FILE_SIZE
    count = os.environ.get(count_name) or str(DEFAULT_FILE_COUNT)
    try:
        byte_count(size)
    except ValueError as error:
        raise ConfigurationError(f"{size_name}={printable(size)}: {error}") from None
    if not count.isdecimal() or int(count) < 1:
        raise ConfigurationError(f"{count_name}={printable(count)} is no number from 1 on")
    log_to_file(path or None, size, int(count))
