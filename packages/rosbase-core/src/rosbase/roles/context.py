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
    key_being_built: str
    """The name, in `nodes` or `agents`, of the component that is being built; or empty."""
    node_freq_hz: float
    state: str | None
    timestamp: int


class Component:
    """What nodes, agents and handlers have in common: they know their manager, or do without."""

    manager: Any
    """The manager, or None. Programs may use what their own manager class adds to it."""
    logger: Any
    """The manager's logger, or one of its own: a `RosbaseLogger`.

    With a `custom_logger` it also has the methods of that.
    """
    _is_initialised = False
    """Whether the constructor of this class has run."""

    def __init__(self, manager: ManagerContext | None) -> None:
        self.manager = manager
        self._key = str(getattr(manager, "key_being_built", ""))
        self._is_initialised = True

    def __getattr__(self, name: str) -> Any:
        """Say what is wrong where a constructor uses what it has not made yet.

        Raises:
            AttributeError: Always; Python asks here only for what is not there.
        """
        if not self._is_initialised and name in ("manager", "logger", "_backend"):
            raise AttributeError(
                f"{type(self).__name__}.__init__ must first call "
                "super().__init__(manager, *args, **kwargs)"
            )
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __repr__(self) -> str:
        return f"<{' '.join([type(self).__name__, *self._repr_parts()])}>"

    def _repr_parts(self) -> list[str]:
        """Return what the repr shows after the class. Works before the constructor has run."""
        return [repr(self._key)] if self._is_initialised and self._key else []

    @property
    def _label(self) -> str:
        """What the log calls it: its key at the manager, or its class."""
        return self._key or type(self).__name__

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
