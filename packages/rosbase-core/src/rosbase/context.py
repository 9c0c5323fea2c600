"""What nodes, agents and handlers see of the manager that registered them."""

from typing import Any, Protocol

from rosbase.backend import Backend

__all__ = ["ManagerContext"]


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
