"""What nodes, agents and handlers see of the manager that registered them, if one did."""

from typing import Any, Protocol

from rosbase.contracts.backend import Backend

__all__ = ["Component", "ManagerContext"]


class ManagerContext(Protocol):
    """The part of a manager that its components rely on. `BaseManager` is one."""

    backend: Backend
    logger: Any
    nodes: dict[str, Any]
    """By name, in order of registration; grows while components are built."""
    agents: dict[str, Any]
    """By name, as `nodes`."""
    node_freq_hz: float
    state: str | None
    timestamp: int


class Component:
    """What nodes, agents and handlers have in common: they know their manager, or do without."""

    def __init__(self, manager: ManagerContext | None) -> None:
        # Any: programs reach for what their own manager class adds.
        self.manager: Any = manager

    @property
    def nodes(self) -> dict[str, Any]:
        """The manager's nodes by name; none without a manager."""
        return self.manager.nodes if self.manager is not None else {}

    @property
    def agents(self) -> dict[str, Any]:
        """The manager's agents by name; none without a manager."""
        return self.manager.agents if self.manager is not None else {}

    @property
    def timestamp(self) -> int:
        """Ticks of the manager's main loop; 0 without a manager."""
        return self.manager.timestamp if self.manager is not None else 0

    @property
    def node_freq_hz(self) -> float:
        """The rate of the manager's main loop; 0 without a manager."""
        return self.manager.node_freq_hz if self.manager is not None else 0.0
