"""The handlers: called once per tick, for scheduling and task state machines."""

from typing import Any, ClassVar

from rosbase.logger import RosbaseLogger
from rosbase.roles.context import Component, ManagerContext

__all__ = ["BaseHandlers"]


class BaseHandlers(Component):
    """Base class of handlers, which decide once per tick what nodes and agents do next."""

    manager: ManagerContext
    """Manager; None in a test without one."""
    _plain_methods: ClassVar[tuple[str, ...]] = ("handle",)

    def __init__(self, manager: ManagerContext | None = None, *args: Any, **kwargs: Any) -> None:
        """Attach to the manager; ignore the other forwarded arguments."""
        super().__init__(manager)
        self.logger = manager.logger if manager is not None else RosbaseLogger(type(self).__name__)
        self._own_state: str | None = None

    def handle(self) -> None:
        """Do the work that is due and return soon. Called once per tick of the main loop."""

    @property
    def timestamp(self) -> int:
        """Number of ticks of the manager's main loop, to read and to set; 0 without a manager."""
        return super().timestamp

    @timestamp.setter
    def timestamp(self, value: int) -> None:
        if self.manager is not None:
            self.manager.timestamp = value

    @property
    def state(self) -> str | None:
        """State of the manager, to read and to set."""
        return self.manager.state if self.manager is not None else self._own_state

    @state.setter
    def state(self, value: str | None) -> None:
        if self.manager is not None:
            self.manager.state = value
        else:
            self._own_state = value
