"""Log levels from the environment: of all loggers, or of one by its name."""

import logging
import os

from rosbase.errors import ConfigurationError
from rosbase.logger.levels import level_number

__all__ = ["LEVEL_VARIABLE", "apply_levels", "levels_in"]

LEVEL_VARIABLE = "ROSBASE_LOG_LEVEL"
"""Environment variable such as `info,camera:=debug`."""

_applied: list[str] = [""]


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


def apply_levels() -> None:
    """Set the levels that the environment names, once: a program may change them later.

    Raises:
        ConfigurationError: A level has no such name.
    """
    text = os.environ.get(LEVEL_VARIABLE, "")
    if text == _applied[0]:
        return
    levels = levels_in(text)
    _applied[0] = text
    ours = logging.getLogger("rosbase")
    for name, level in levels:
        (ours.getChild(name) if name else ours).setLevel(level)
