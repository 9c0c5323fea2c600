"""Questions of rclpy's thread to the program, whose callbacks run only on the main loop."""

import threading
from collections.abc import Callable
from typing import TypeVar

__all__ = ["Questions"]

AnswerT = TypeVar("AnswerT")

# A main loop that is busy for longer would hold up every service of the node.
_PATIENCE_S = 2.0


class Questions:
    """Asks the main loop, and waits for its answer."""

    def __init__(
        self, call_soon: Callable[[Callable[[], object]], object], is_foreign: Callable[[], bool]
    ) -> None:
        """Prepare to ask.

        Args:
            call_soon: Queues a call for the main loop, also while that waits for an answer of a
                service.
            is_foreign: Whether the caller is on rclpy's thread; any other thread answers by
                itself.
        """
        self._call_soon = call_soon
        self._is_foreign = is_foreign

    @property
    def is_foreign(self) -> bool:
        """Whether the caller is on rclpy's thread."""
        return self._is_foreign()

    def ask(
        self,
        question: Callable[[], AnswerT],
        without: Callable[[str], AnswerT],
        queue: Callable[[Callable[[], object]], object] | None = None,
    ) -> AnswerT:
        """Return the answer of the main loop.

        Args:
            question: Called on the main loop, unless it comes too late.
            without: Makes the answer from a reason, if the main loop does not answer.
            queue: Queues a call for the main loop; by default, as given to the constructor.
        """
        if not self._is_foreign():
            return question()
        answers: list[AnswerT] = []
        is_answered = threading.Event()
        is_open = threading.Lock()

        def answer() -> None:
            # Taken here or by who has given up, whoever is first.
            if is_open.acquire(blocking=False):
                try:
                    answers.append(question())
                finally:
                    is_answered.set()

        (queue or self._call_soon)(answer)
        is_answered.wait(_PATIENCE_S)
        if not answers and is_open.acquire(blocking=False):
            return without(f"the main loop has not answered for {_PATIENCE_S:g} s")
        is_answered.wait()
        return answers[0] if answers else without("the program failed")
