"""A lifecycle node of a manager: it shares the connection, and has services of its own name."""

from collections.abc import Callable

from rosbase.contracts.node_connection import NodeConnection
from rosbase.contracts.node_view import NodeView
from rosbase.lifecycle import ManagedNode

__all__ = ["LocalNode"]


class LocalNode(NodeView):
    """The connection of a lifecycle node."""

    def __init__(
        self,
        shared: NodeConnection,
        name: str,
        offer_lifecycle: Callable[[str, ManagedNode], object],
    ) -> None:
        """Share a connection.

        Args:
            shared: That of the manager.
            name: The name of the node.
            offer_lifecycle: Answers the standard services of a node, under a name.
        """
        super().__init__(shared, name, is_lifecycle=True)
        self._offer_lifecycle = offer_lifecycle

    def expose_lifecycle(self, node: ManagedNode) -> None:
        """Answer the standard services of a lifecycle node under the name of this one."""
        self._offer_lifecycle(self.node_name, node)
