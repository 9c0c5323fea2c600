"""The agent: computation, with no publishers and no subscriptions."""

from abc import ABC, abstractmethod
from typing import Any

from rosbase.clock import Clock, SystemClock
from rosbase.context import ManagerContext
from rosbase.logger import RosbaseLogger

__all__ = ["BaseAgent"]


class BaseAgent(ABC):
    """Computes. It reads the manager's context, and works without one, as in a test."""

    def __init__(self, manager: ManagerContext | None = None, *args: Any, **kwargs: Any) -> None:
        """Attaches to the manager, if there is one; ignores whatever else is forwarded."""
        # Any: programs reach for what their own manager class adds.
        self.manager: Any = manager
        self.logger = manager.logger if manager is not None else RosbaseLogger(type(self).__name__)

    @abstractmethod
    def reset(self) -> None:
        """Called to start afresh. Forget what has been computed so far."""

    @property
    def nodes(self) -> dict[str, Any]:
        """The manager's nodes by name; none without a manager."""
        return self.manager.nodes if self.manager is not None else {}

    @property
    def agents(self) -> dict[str, Any]:
        """The manager's agents by name; none without a manager."""
        return self.manager.agents if self.manager is not None else {}

    @property
    def state(self) -> str | None:
        """The manager's state; None without a manager."""
        return self.manager.state if self.manager is not None else None

    @property
    def timestamp(self) -> int:
        """Ticks of the manager's main loop; 0 without a manager."""
        return self.manager.timestamp if self.manager is not None else 0

    @property
    def node_freq_hz(self) -> float:
        """The rate of the manager's main loop; 0 without a manager."""
        return self.manager.node_freq_hz if self.manager is not None else 0.0

    def get_clock(self) -> Clock:
        """The manager's clock; this machine's without a manager."""
        return self.manager.backend.clock if self.manager is not None else SystemClock()
