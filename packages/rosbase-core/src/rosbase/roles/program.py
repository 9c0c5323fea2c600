"""A standalone node, as clients of the control socket see it."""

from typing import TYPE_CHECKING

from rosbase.contracts.recording import Recording
from rosbase.control.programs import Program, RunningNode
from rosbase.lifecycle import ManagedNode

if TYPE_CHECKING:
    from rosbase.roles.node import BaseNode

__all__ = ["NodeProgram", "running_node"]


class NodeProgram(Program):
    """A standalone node."""

    kind = "node"

    def __init__(self, node: "BaseNode") -> None:
        self._node = node
        self.backend = node._backend

    @property
    def class_name(self) -> str:
        """Class of the node."""
        return type(self._node).__name__

    @property
    def recording(self) -> Recording | None:
        """The recording that the node makes of itself."""
        return self._node._recording

    def nodes(self) -> list[RunningNode]:
        """Return the node itself."""
        return [running_node(self._node, "")]

    def request_stop(self) -> None:
        """End the spinning of the node."""
        self._node.request_stop()


def running_node(node: "BaseNode", key: str) -> RunningNode:
    """Describe a node that has a connection."""
    managed: ManagedNode | None = node if node._is_lifecycle else None  # type: ignore[assignment]  # so it is one
    return RunningNode(
        f"/{node._connection.node_name}", key, type(node).__name__, node._connection, managed
    )
