"""Log records kept for a test."""

import logging

__all__ = ["RecordedLog"]


class RecordedLog(logging.Handler):
    """Records of the loggers of one name, at every level, until it is closed."""

    def __init__(self, name: str) -> None:
        """Listen to `rosbase.<name>`, the logger of `RosbaseLogger(name)`."""
        super().__init__()
        self.records: list[logging.LogRecord] = []
        self._logger = logging.getLogger(f"rosbase.{name}")
        self._level_before = self._logger.level
        self._logger.setLevel(logging.DEBUG)
        self._logger.addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a record."""
        self.records.append(record)

    @property
    def lines(self) -> list[str]:
        """Messages so far."""
        return [record.getMessage() for record in self.records]

    def tells_of(self, error: BaseException) -> bool:
        """Return whether the exception was logged as an error, in words or with a traceback."""
        return any(
            record.levelno >= logging.ERROR
            and (repr(error) in record.getMessage() or error in (record.exc_info or ()))
            for record in self.records
        )

    def close(self) -> None:
        """Stop listening."""
        self._logger.removeHandler(self)
        self._logger.setLevel(self._level_before)
        super().close()
