"""A manager, as clients of the control socket see it."""

from typing import TYPE_CHECKING, Any

from rosbase.contracts.recording import Recording
from rosbase.control.programs import Program, RunningNode
from rosbase.roles.node import BaseNode
from rosbase.roles.program import running_node

if TYPE_CHECKING:
    from rosbase.manager.base_manager import BaseManager

__all__ = ["ManagerProgram"]


class ManagerProgram(Program):
    """A manager."""

    kind = "manager"

    def __init__(self, manager: "BaseManager") -> None:
        self._manager = manager
        self.backend = manager.backend
        self.loop_stats = manager.loop_stats

    @property
    def class_name(self) -> str:
        """Class of the manager."""
        return type(self._manager).__name__

    @property
    def recording(self) -> Recording | None:
        """The recording that the manager makes of its program."""
        return self._manager._recording

    def nodes(self) -> list[RunningNode]:
        """Return the manager's own node, and those that it has registered."""
        manager, found = self._manager, []
        own = RunningNode(self.name, "", self.class_name, manager.backend)
        for key, node in manager.nodes.items():
            if not hasattr(node, "_connection"):
                # A component that uses nothing of rosbase may do without.
                found.append(RunningNode(self.name, key, type(node).__name__, None))
            elif isinstance(node, BaseNode) and node._connection is manager.backend:
                # A lifecycle node of the manager's name is its own node.
                own = running_node(node, key)
            else:
                found.append(running_node(node, key))
        return [own, *found]

    def facts(self) -> dict[str, Any]:
        """Return state, rate and children, and what the handshake waits for."""
        manager = self._manager
        state = manager.state
        children = dict(manager._processes or {})
        return {
            "state": state if state is None else str(state),
            "rate_hz": float(manager.node_freq_hz),
            "waiting_for": self._pending() if self.phase == "handshake" else [],
            "children": [
                {"name": name, "pid": child.pid, "running": child.is_alive}
                for name, child in children.items()
            ],
        }

    def request_stop(self) -> None:
        """End the main loop of the manager."""
        self._manager.request_stop()

    def _pending(self) -> list[str]:
        return self._manager._handshake.pending or ["the manager's own handshake"]
