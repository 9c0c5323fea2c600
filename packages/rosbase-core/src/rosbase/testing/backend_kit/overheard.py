"""What a program says meanwhile: its log, and whatever anybody in the process writes to stderr."""

import logging
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr
from tempfile import TemporaryFile

__all__ = ["overhearing"]


class _Keeper(logging.Handler):
    """Keeps the texts of warnings."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(record.getMessage())


@contextmanager
def overhearing() -> Iterator[Callable[[], str]]:
    """Gives a function that tells what has been said within the block.

    That of libraries in C too, which write to the descriptor. Nothing of it is on stderr then.
    """
    keeper, logger = _Keeper(), logging.getLogger()
    sys.stderr.flush()
    real = os.dup(2)
    # Whoever reads it, what is written goes to the end.
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
