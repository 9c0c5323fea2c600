"""The agent: computation, with no publishers and no subscriptions."""

from abc import ABC, abstractmethod
from typing import Any

from rosbase.clock import Clock, SystemClock
from rosbase.logger import RosbaseLogger
from rosbase.roles.context import Component, ManagerContext

__all__ = ["BaseAgent"]


class BaseAgent(Component, ABC):
    """Computes. It reads the manager's context, and works without one, as in a test."""

    def __init__(self, manager: ManagerContext | None = None, *args: Any, **kwargs: Any) -> None:
        """Attaches to the manager, if there is one; ignores whatever else is forwarded."""
        super().__init__(manager)
        self.logger = manager.logger if manager is not None else RosbaseLogger(type(self).__name__)

    @abstractmethod
    def reset(self) -> None:
        """Forget what has been computed so far.

        rosbase never calls it: your program does, for example before each task or each test.
        """

    def close(self) -> None:
        """Called by programs whose `release_resources` closes all agents. Release what it holds."""

    @property
    def state(self) -> str | None:
        """The manager's state; None without a manager."""
        return self.manager.state if self.manager is not None else None

    def get_clock(self) -> Clock:
        """The manager's clock; this machine's without a manager."""
        return self.manager.backend.clock if self.manager is not None else SystemClock()
