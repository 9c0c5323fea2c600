"""The log file that ROS opens for a process, below `ROS_LOG_DIR` or `ROS_HOME`."""

import logging
import os
import re
from pathlib import Path

from rclpy.logging import get_logging_directory

from rosbase import RosFormatter

__all__ = ["LogFile"]


class LogFile:
    """Appends records to the file, in the format of the console.

    rcl cannot write only to its file: its records go to its console too, where these records
    already are. rcl appends to the file, so both may write.
    """

    def __init__(self, path: Path) -> None:
        """Take the path of an existing file."""
        self.path = path
        self._formatter = RosFormatter()

    @classmethod
    def of_this_process(cls) -> "LogFile | None":
        """Return the file that rcl has opened for this process, if there is one."""
        try:
            found = _newest(Path(get_logging_directory()), os.getpid())
        except (OSError, RuntimeError):
            return None
        return cls(found) if found else None

    def write(self, record: logging.LogRecord) -> None:
        """Append a record. It never raises: a full disk must not stop the program."""
        try:
            # Opened each time: records are few, and the file lives as long as the process.
            file = os.open(self.path, os.O_WRONLY | os.O_APPEND | os.O_CLOEXEC)
            try:
                os.write(file, f"{self._formatter.format(record)}\n".encode(errors="replace"))
            finally:
                os.close(file)
        except OSError:
            # Such as one that was deleted; then ROS writes to nowhere, too.
            pass


def _newest(folder: Path, pid: int) -> Path | None:
    """Return the newest `<program>_<pid>_<milliseconds>.log`, because pids are used again."""
    name = re.compile(rf".*_{pid}_(\d+)\.log")
    matches = [
        (int(found[1]), path) for path in folder.iterdir() if (found := name.fullmatch(path.name))
    ]
    return max(matches)[1] if matches else None
