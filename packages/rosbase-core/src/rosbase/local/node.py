"""A lifecycle node of a manager: it shares the connection, and has services of its own name."""

from rosbase.contracts.node_connection import NodeConnection
from rosbase.contracts.node_view import NodeView
from rosbase.lifecycle import ManagedNode
from rosbase.local.standard.offers import StandardOffers

__all__ = ["LocalNode"]


class LocalNode(NodeView):
    """The connection of a lifecycle node."""

    def __init__(self, shared: NodeConnection, name: str, standard: StandardOffers) -> None:
        """Share a connection.

        Args:
            shared: That of the manager.
            name: The name of the node.
            standard: Answers the standard services of its nodes.
        """
        super().__init__(shared, name, is_lifecycle=True)
        self._standard = standard

    def parameter_names(self) -> list[str]:
        """Return the names of the node's parameters."""
        return self._standard.parameters_of(self._prefix).names()

    def expose_lifecycle(self, node: ManagedNode) -> None:
        """Answer the standard services of a lifecycle node under the name of this one."""
        self._standard.offer_lifecycle(self.node_name, node)
