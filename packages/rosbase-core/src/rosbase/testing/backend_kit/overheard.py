"""Output of a program during a check: its log, and all writes of the process to stderr."""

import logging
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr
from tempfile import TemporaryFile

__all__ = ["overhearing"]


class _Keeper(logging.Handler):
    """Handler that keeps the texts of warnings."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(record.getMessage())


@contextmanager
def overhearing() -> Iterator[Callable[[], str]]:
    """Yield a function that returns the output within the block.

    It includes the output of C libraries, which write to the descriptor. None of it is on stderr.
    """
    keeper, logger = _Keeper(), logging.getLogger()
    sys.stderr.flush()
    real = os.dup(2)
    # Writes always go to the end, also after reads.
    with TemporaryFile("a+", errors="replace") as file, redirect_stderr(file):
        os.dup2(file.fileno(), 2)
        logger.addHandler(keeper)

        def said() -> str:
            file.seek(0)
            return "\n".join([*keeper.texts, file.read()])

        try:
            yield said
        finally:
            logger.removeHandler(keeper)
            os.dup2(real, 2)
            os.close(real)
