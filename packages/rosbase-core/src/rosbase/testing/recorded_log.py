"""What somebody logs, kept for a test."""

import logging

__all__ = ["RecordedLog"]


class RecordedLog(logging.Handler):
    """Listens to the loggers of one name until it is closed, at every level."""

    def __init__(self, name: str) -> None:
        """Begins to listen to `rosbase.<name>`, the logger of `RosbaseLogger(name)`."""
        super().__init__()
        self.records: list[logging.LogRecord] = []
        self._logger = logging.getLogger(f"rosbase.{name}")
        self._level_before = self._logger.level
        self._logger.setLevel(logging.DEBUG)
        self._logger.addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        """Keeps a record."""
        self.records.append(record)

    @property
    def lines(self) -> list[str]:
        """The messages so far."""
        return [record.getMessage() for record in self.records]

    def tells_of(self, error: BaseException) -> bool:
        """Whether that exception has been logged as an error, in words or with its traceback."""
        return any(
            record.levelno >= logging.ERROR
            and (repr(error) in record.getMessage() or error in (record.exc_info or ()))
            for record in self.records
        )

    def close(self) -> None:
        """Stops listening."""
        self._logger.removeHandler(self)
        self._logger.setLevel(self._level_before)
        super().close()
