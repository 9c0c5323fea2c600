"""The logger of the four roles, and the destinations of its records."""

from rosbase.logger.console import Console, use_console
from rosbase.logger.custom import make_logger
from rosbase.logger.filters import LogOptions
from rosbase.logger.formatter import RosFormatter
from rosbase.logger.levels import level_number
from rosbase.logger.log_file import log_to_file
from rosbase.logger.rosbase_logger import RosbaseLogger

__all__ = [
    "Console",
    "LogOptions",
    "RosFormatter",
    "RosbaseLogger",
    "level_number",
    "log_to_file",
    "make_logger",
    "use_console",
]
