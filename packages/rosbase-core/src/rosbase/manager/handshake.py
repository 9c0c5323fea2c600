"""The handshake: rules that must all hold before the main loop may start."""

from collections.abc import Callable

from rosbase.contracts.backend import Backend
from rosbase.errors import HandshakeTimeoutError
from rosbase.logger import RosbaseLogger
from rosbase.roles.callables import check_answer, check_callback

__all__ = ["Handshake"]

_SLICE_NS = 100_000_000
# Most waits are over before anybody wonders.
_FIRST_REPORT_S = 1.0
_REPORT_S = 5.0


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

    def wait(
        self,
        backend: Backend,
        is_pending: Callable[[], bool],
        is_stopping: Callable[[], object],
        timeout_s: float | None,
        hint: Callable[[], str],
    ) -> None:
        """Handle messages until the handshake has succeeded, or the program is to stop.

        Args:
            backend: Spun meanwhile.
            is_pending: Whether the handshake has not succeeded yet; usually asks `ask`.
            is_stopping: Whether the program is to stop.
            timeout_s: Limit of the wait, if there is one.
            hint: Returns the end of a line about rules that do not hold.

        Raises:
            HandshakeTimeoutError: It did not succeed in time; the text names what is missing.
        """
        clock = backend.clock
        start_ns = clock.monotonic_ns()
        while not is_stopping() and is_pending():
            pending = ", ".join(self.pending) or "the manager's own handshake"
            waited_s = (clock.monotonic_ns() - start_ns) / 1e9
            if timeout_s is not None and waited_s >= timeout_s:
                raise HandshakeTimeoutError(
                    f"after {waited_s:.1f} s still waiting for: {pending}{hint()}"
                )
            if waited_s >= _FIRST_REPORT_S:
                self._logger.log_throttle(f"waiting for: {pending}{hint()}", _REPORT_S)
            backend.spin_until(clock.monotonic_ns() + _SLICE_NS, is_stopping)

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
