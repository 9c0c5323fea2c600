"""The logger of the four roles, and the destinations of its records."""

from rosbase.logger.console import Console, use_console
from rosbase.logger.custom import make_logger
from rosbase.logger.environment import LEVEL_VARIABLE, apply_levels, levels_in
from rosbase.logger.filters import LogOptions
from rosbase.logger.formatter import RosFormatter
from rosbase.logger.levels import level_number
from rosbase.logger.rosbase_logger import RosbaseLogger

__all__ = [
    "LEVEL_VARIABLE",
    "Console",
    "LogOptions",
    "RosFormatter",
    "RosbaseLogger",
    "apply_levels",
    "level_number",
    "levels_in",
    "make_logger",
    "use_console",
]
