"""Asks an AI whether the robot may go on."""

from typing import Any

from rosbase import BaseAgent

THINKING_TICKS = 5
ANSWERS = (False, True, True, None, True)


class Confirmer(BaseAgent):
    """Thinks for a few ticks, then has a verdict.

    A stand-in for a vision-language model: the answers are written down above. None is the
    answer that never comes.
    """

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.answers = iter(ANSWERS)
        self.reset()

    def reset(self) -> None:
        """Called when there is a new question: the last verdict does not count for it."""
        self.ticks = 0
        self.verdict: bool | None = None

    def think(self) -> None:
        """Called once per tick while an answer is wanted. Real models think elsewhere."""
        self.ticks += 1
        if self.ticks == THINKING_TICKS:
            self.verdict = next(self.answers, True)

    def close(self) -> None:
        """Called by the manager at the end: where a model would be unloaded."""
