"""The handshake: rules that must all hold before the main loop may start."""

from collections.abc import Callable

from rosbase.logger import RosbaseLogger
from rosbase.roles.callables import check_answer, check_callback

__all__ = ["Handshake"]


class Handshake:
    """Named rules, checked again and again until all of them hold."""

    def __init__(self, logger: RosbaseLogger) -> None:
        self._logger = logger
        self._rules: list[tuple[str, Callable[[], object]]] = []
        self._reported: set[int] = set()
        self.pending: list[str] = []
        """Names of the rules that did not hold at the last check."""

    def add(self, name: str, predicate: Callable[[], object]) -> None:
        """Add a rule; the user who waits reads its name.

        Raises:
            TypeError: The predicate cannot be called, or is async or a generator.
        """
        check_callback(predicate, f"handshake rule '{name}'")
        self._rules.append((name, predicate))

    def ask(self) -> bool:
        """Return whether all rules hold. A rule that raises does not, and is named once.

        Raises:
            TypeError: A rule returned a coroutine or a generator.
        """
        held = [self._holds(index) for index in range(len(self._rules))]
        self.pending = [
            name for (name, _), holds in zip(self._rules, held, strict=True) if not holds
        ]
        return not self.pending

    def _holds(self, index: int) -> bool:
        name, predicate = self._rules[index]
        try:
            answer = predicate()
            holds = bool(answer)
        except Exception as error:
            if index not in self._reported:
                self._reported.add(index)
                self._logger.warning(
                    f"handshake rule '{name}' raised {type(error).__name__}: {error}"
                )
            return False
        check_answer(answer, f"handshake rule '{name}'")
        return holds
