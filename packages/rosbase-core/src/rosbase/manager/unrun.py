"""Log that a method returned work which nobody runs."""

from rosbase.logger import RosbaseLogger
from rosbase.roles.callables import describe_unrun

__all__ = ["UnrunWork"]


class UnrunWork:
    """Reports coroutines and generators that a method returned, once for each method."""

    def __init__(self, logger: RosbaseLogger) -> None:
        self._logger = logger
        self._reported: set[str] = set()

    def report(self, of: object, name: str, answer: object) -> None:
        """Log it if the answer of a method is such work.

        Args:
            of: The object that has the method.
            name: The method's name.
            answer: The value that it returned.
        """
        what = f"{type(of).__name__}.{name}"
        text = describe_unrun(answer, what)
        if text and what not in self._reported:
            self._reported.add(what)
            self._logger.error(text)
