"""The agent: computation, with no publishers and no subscriptions."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from rosbase.clock import Clock, SystemClock
from rosbase.logger import RosbaseLogger
from rosbase.roles.context import Component, ManagerContext

__all__ = ["BaseAgent"]


class BaseAgent(Component, ABC):
    """Base class of agents, which compute.

    An agent reads the manager's context, and works without one, as in a test.
    """

    _plain_methods: ClassVar[tuple[str, ...]] = ("reset", "close")

    def __init__(self, manager: ManagerContext | None = None, *args: Any, **kwargs: Any) -> None:
        """Attach to the manager, if there is one; ignore the other forwarded arguments."""
        super().__init__(manager)
        self.logger = manager.logger if manager is not None else RosbaseLogger(type(self).__name__)

    @abstractmethod
    def reset(self) -> None:
        """Forget all computed results.

        rosbase never calls it: your program does, for example before each task or each test.
        """

    def close(self) -> None:
        """Release resources. Called by programs whose `release_resources` closes all agents."""

    @property
    def state(self) -> str | None:
        """State of the manager; None without a manager."""
        return self.manager.state if self.manager is not None else None

    def get_clock(self) -> Clock:
        """Return the manager's clock, or this machine's without a manager."""
        return self.manager.backend.clock if self.manager is not None else SystemClock()
