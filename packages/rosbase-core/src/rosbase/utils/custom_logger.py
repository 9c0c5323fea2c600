"""A logger with a level and a file, as programs written for ros_base make it."""

from pathlib import Path

from rosbase.logger import RosbaseLogger
from rosbase.logger.log_file import DEFAULT_FILE_COUNT, DEFAULT_FILE_SIZE, log_file_at

__all__ = ["CustomLogger"]


class CustomLogger(RosbaseLogger):
    """A logger made by hand, or by a manager: `BaseManager(custom_logger=CustomLogger)`.

    It has all methods and rules of `RosbaseLogger`.
    """

    def __init__(
        self,
        name: str,
        level: str | int | None = None,
        log_file: str | Path | None = None,
        rotation: str | int | None = DEFAULT_FILE_SIZE,
        retention: int = DEFAULT_FILE_COUNT,
    ) -> None:
        """Make the logger.

        Args:
            name: Name of its records.
            level: Minimum level that is logged; by default INFO, or the level set in `logging`.
            log_file: Path of a file to which its records are appended, besides the console. Loggers
                with the same path share the file. If it cannot be written, the log has one warning.
            rotation: Size from which a new file is begun: bytes, or a text such as `10 MB`. None
                stands for never.
            retention: Number of old files that are kept, as `<log_file>.1` and so on.

        Raises:
            ValueError: No level has that name, the size is none, or the number is below 1.
        """
        super().__init__(name)
        if level is not None:
            self.set_level(level)
        if log_file is not None:
            self._file = log_file_at(log_file, rotation or 0, retention)

    def close(self) -> None:
        """Close the file. The next record opens it again."""
        if self._file is not None:
            self._file.close()
