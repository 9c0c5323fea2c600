"""The log file of all loggers of a program, and the files of single loggers.

The file itself is imported when there is one, because few programs have one.
"""

import os
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from rosbase.logger.sizes import byte_count

if TYPE_CHECKING:
    from rosbase.logger.rotating_file import LogFile

__all__ = [
    "DEFAULT_FILE_COUNT",
    "DEFAULT_FILE_SIZE",
    "current_log_file",
    "log_file_at",
    "log_to_file",
    "use_log_file",
]

DEFAULT_FILE_SIZE = "10 MB"
DEFAULT_FILE_COUNT = 5

_of_paths: dict[str, "LogFile"] = {}
_of_program: list["LogFile"] = []


def log_file_at(
    path: str | Path, max_size: str | int, count: int = DEFAULT_FILE_COUNT
) -> "LogFile":
    """Return the log file at a path. In one process, there is one for each path.

    Args:
        path: Path of the file; `~` is the user's home.
        max_size: Size from which a new file is begun, such as `10 MB`; 0 for never. What was said
            last counts.
        count: Number of old files that are kept.

    Raises:
        ValueError: The size is none, or the number is below 1.
    """
    max_bytes = byte_count(max_size)
    if count < 1:
        raise ValueError(f"the number of old log files is 1 or more, not {count}")
    key = os.path.abspath(os.path.expanduser(path))
    file = _of_paths.get(key)
    if file is None:
        module = import_module("rosbase.logger.rotating_file")
        file = _of_paths[key] = module.LogFile(key, max_bytes, count)
    file.maxBytes, file.backupCount = max_bytes, count
    return file


def current_log_file() -> "LogFile | None":
    """Return the log file of the program, if it has one."""
    return _of_program[0] if _of_program else None


def use_log_file(file: "LogFile | None") -> None:
    """Write the records of all loggers to that file too; with None, close the one so far."""
    for before in _of_program:
        before.close()
    _of_program[:] = [] if file is None else [file]


def log_to_file(
    path: str | Path | None,
    max_size: str | int = DEFAULT_FILE_SIZE,
    count: int = DEFAULT_FILE_COUNT,
) -> None:
    """Write the records of all rosbase loggers of this process to a file too.

    Child processes send their records to the manager, which writes them to its file. If the file
    cannot be written, the log has one warning, and the program goes on.

    Args:
        path: Path of the file, to which lines are appended; `~` is the user's home. None ends it.
        max_size: Size from which a new file is begun: bytes, or a text such as `10 MB`; 0 for
            never.
        count: Number of old files that are kept, as `<path>.1` and so on.

    Raises:
        ValueError: The size is none, or the number is below 1.
    """
    use_log_file(None if path is None else log_file_at(path, max_size, count))
