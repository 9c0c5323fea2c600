"""The handshake: rules that must all hold before the main loop may start."""

from collections.abc import Callable

from rosbase.logger import RosbaseLogger

__all__ = ["Handshake"]


class Handshake:
    """Named rules, asked again and again until all of them hold."""

    def __init__(self, logger: RosbaseLogger) -> None:
        self._logger = logger
        self._rules: list[tuple[str, Callable[[], object]]] = []
        self._reported: set[str] = set()

    def add(self, name: str, predicate: Callable[[], object]) -> None:
        """Adds a rule; the name is what a waiting user reads."""
        self._rules.append((name, predicate))

    def pending(self) -> list[str]:
        """The names of the rules that do not hold. One that raises does not, and is named once."""
        return [name for name, predicate in self._rules if not self._holds(name, predicate)]

    def _holds(self, name: str, predicate: Callable[[], object]) -> bool:
        try:
            return bool(predicate())
        except Exception as error:
            if name not in self._reported:
                self._reported.add(name)
                self._logger.warning(
                    f"handshake rule '{name}' raised {type(error).__name__}: {error}"
                )
            return False
