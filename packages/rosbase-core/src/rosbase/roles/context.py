"""The view that nodes, agents and handlers have of their manager, if they have one."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar

from rosbase.contracts.backend import Backend
from rosbase.logger import RosbaseLogger
from rosbase.roles.callables import check_methods
from rosbase.roles.lookup import find_component
from rosbase.roles.registration import Registration
from rosbase.roles.set_by_constructor import SetByConstructor
from rosbase.runtime.rate import LoopStats

if TYPE_CHECKING:
    from rosbase.roles.agent import BaseAgent
    from rosbase.roles.handlers import BaseHandlers
    from rosbase.roles.node import BaseNode

__all__ = ["Component", "ManagerContext"]

_ARGUMENTS = "manager, *args, **kwargs"

NodeT = TypeVar("NodeT", bound="BaseNode")
AgentT = TypeVar("AgentT", bound="BaseAgent")


class _Name(SetByConstructor):
    """The name of a component, which no constructor sets: a subclass may have such a property."""

    __slots__ = ()

    def __get__(self, built: Any, owner: type) -> Any:
        """Return the name in the log, unless the program has set another."""
        if built is None or not built._is_initialised:
            return super().__get__(built, owner)
        return built._label


class ManagerContext(Protocol):
    """Part of a manager that its components use. `BaseManager` has it."""

    # Properties, where a manager's own class may have a narrower type.
    @property
    def backend(self) -> Backend:
        """Connection of this process."""
        ...

    @property
    def logger(self) -> RosbaseLogger:
        """Logger of the manager and its components."""
        ...

    @property
    def handlers(self) -> "BaseHandlers | None":
        """Handlers; None without any, and while components are built."""
        ...

    nodes: dict[str, Any]
    """Nodes by name, in order of registration; grows while components are built."""
    agents: dict[str, Any]
    """Agents by name, as `nodes`."""
    _registration: Registration
    """Key for the component that is being built."""
    node_freq_hz: float
    state: str | None
    timestamp: int
    loop_stats: LoopStats
    """Statistics of the main loop."""

    def node(self, node_class: type[NodeT], name: str | None = None) -> NodeT:
        """Return the node of that class: the only one, or the one of that name."""
        ...

    def agent(self, agent_class: type[AgentT], name: str | None = None) -> AgentT:
        """Return the agent of that class, as `node`."""
        ...

    def add_handshake_rule(self, name: str, predicate: Callable[[], object]) -> None:
        """Add a condition that must hold before the main loop starts."""

    def request_stop(self) -> None:
        """End the main loop after the current tick."""


class Component:
    """Base class of nodes, agents and handlers. It knows the manager, or works without one."""

    manager: ManagerContext | None
    """Manager; None without one.

    To use additions of your own manager class with their types, keep it in an attribute of your
    own: `self.robot = manager`.
    """
    logger: RosbaseLogger
    """Logger of the manager, or one of its own.

    With a `custom_logger` it also has the methods of that class. To use them, declare
    `logger: Any` in the component.
    """
    name: str
    """Key in `nodes` or `agents` of the manager, or the name of a standalone node.

    A program may use this attribute for something else: rosbase does not read it.
    """
    _is_initialised = False
    """Whether the constructor of this class has run."""
    _plain_methods: ClassVar[tuple[str, ...]] = ()
    """Methods that must be plain functions: neither async nor generators."""
    _key = ""
    """Name in `nodes` or `agents` of the manager; empty if there is none."""

    if not TYPE_CHECKING:  # a type checker needs the types above
        manager = SetByConstructor(_ARGUMENTS)
        logger = SetByConstructor(_ARGUMENTS)
        name = _Name(_ARGUMENTS)
        _backend = SetByConstructor(_ARGUMENTS)
        _connection = SetByConstructor(_ARGUMENTS)
        _machine = SetByConstructor(_ARGUMENTS)

    def __init__(self, manager: ManagerContext | None) -> None:
        check_methods(self, self._plain_methods)
        self.manager = manager
        # A stand-in for a manager, in a test of the application, may have none.
        registration: Registration | None = getattr(manager, "_registration", None)
        if registration is not None and not self._key:
            self._key = registration.take_key(self)
        self._is_initialised = True

    def __repr__(self) -> str:
        return f"<{' '.join([type(self).__name__, *self._repr_parts()])}>"

    def _repr_parts(self) -> list[str]:
        """Return the part of the repr after the class. Works before the constructor has run."""
        return [repr(self._key)] if self._is_initialised and self._key else []

    @property
    def _label(self) -> str:
        """Name in the log: its key at the manager, or its class."""
        return self._key or type(self).__name__

    @property
    def nodes(self) -> dict[str, Any]:
        """Nodes of the manager by name; none without a manager."""
        return self.manager.nodes if self.manager is not None else {}

    @property
    def agents(self) -> dict[str, Any]:
        """Agents of the manager by name; none without a manager."""
        return self.manager.agents if self.manager is not None else {}

    def node(self, node_class: type[NodeT], name: str | None = None) -> NodeT:
        """Return the manager's node of that class, typed as such.

        Args:
            node_class: Its class, or a base of it.
            name: Its name in `nodes`, needed only if several nodes are of the class.

        Raises:
            LookupError: There is none, or several and no name. Nodes are built in the order of
                `nodes_dict`.
        """
        return find_component(self.nodes, node_class, name, "node")

    def agent(self, agent_class: type[AgentT], name: str | None = None) -> AgentT:
        """Return the manager's agent of that class, as `node` does for nodes.

        Raises:
            LookupError: There is none, or several and no name.
        """
        return find_component(self.agents, agent_class, name, "agent")

    @property
    def timestamp(self) -> int:
        """Number of ticks of the manager's main loop; 0 without a manager."""
        return self.manager.timestamp if self.manager is not None else 0

    @property
    def node_freq_hz(self) -> float:
        """Rate of the manager's main loop; 0 without a manager."""
        return self.manager.node_freq_hz if self.manager is not None else 0.0
