"""The backend of a replayed program that ran on a middleware."""

from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.contracts.names import check_node_name
from rosbase.contracts.node_connection import NodeConnection
from rosbase.contracts.recorded_answers import parameters_from
from rosbase.entries.conductor import conductor_of
from rosbase.entries.kinds import Kind
from rosbase.entries.script import Entry
from rosbase.errors import BackendError
from rosbase.local.replayed.node import ReplayedNode
from rosbase.local.replayed.program import ReplayedProgram

__all__ = ["ReplayedBackend"]


class ReplayedBackend(ReplayedNode, Backend):
    """The connection of a program to its recording."""

    def __init__(self, options: BackendOptions) -> None:
        """Open it, with the clock of a replay."""
        conductor = conductor_of(options.clock)
        if conductor is None:
            raise BackendError("only a replay has this backend")
        Backend.__init__(self, options.clock, options.node_name)
        machine = getattr(options.clock, "machine", options.clock)
        program = ReplayedProgram(conductor, machine, self.executor, self.new_ends)
        conductor.register(Kind.PARAM, self._set_parameters)
        self.set_up(program, options.node_name)

    def open_node(self, name: str, *, is_lifecycle: bool) -> NodeConnection:
        """Open the connection of a node; a lifecycle node has a name of its own."""
        if not is_lifecycle:
            return Backend.open_node(self, name, is_lifecycle=False)
        check_node_name(name)
        self._program.check_open()
        node = ReplayedNode()
        node.set_up(self._program, f"{self.node_name.rpartition('/')[0]}/{name}".removeprefix("/"))
        return node

    def close(self) -> None:
        """Close everything."""
        program = self._program
        if program.is_closed:
            return
        program.is_closed = True
        for publisher in program.publishers:
            publisher.close()
        for subscription in program.subscriptions:
            subscription.close()
        for service in list(program.services.values()):
            service.close()
        for client in program.clients:
            client.close()
        self.executor.close()

    def _set_parameters(self, entry: Entry) -> None:
        """Set parameters as somebody outside has done, when the main loop comes to it."""
        name, parameters = parameters_from(entry.payload)
        node = self._program.nodes[name]
        self.executor.call_urgently(lambda: node.take(parameters))
