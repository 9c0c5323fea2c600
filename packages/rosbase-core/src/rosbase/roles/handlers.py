"""The handlers: one call per cycle, where scheduling and task state machines live."""

from typing import Any

from rosbase.logger import RosbaseLogger
from rosbase.roles.context import Component, ManagerContext

__all__ = ["BaseHandlers"]


class BaseHandlers(Component):
    """Decides, once per tick, what nodes and agents do next."""

    def __init__(self, manager: ManagerContext | None = None, *args: Any, **kwargs: Any) -> None:
        """Attaches to the manager; ignores whatever else is forwarded."""
        super().__init__(manager)
        self.logger = manager.logger if manager is not None else RosbaseLogger(type(self).__name__)
        self._own_state: str | None = None

    def handle(self) -> None:
        """Called once per tick of the main loop. Do what is due and return soon."""

    @property
    def timestamp(self) -> int:
        """Ticks of the manager's main loop, to read and to set; 0 without a manager."""
        return super().timestamp

    @timestamp.setter
    def timestamp(self, value: int) -> None:
        if self.manager is not None:
            self.manager.timestamp = value

    @property
    def state(self) -> str | None:
        """The manager's state, to read and to set."""
        return self.manager.state if self.manager is not None else self._own_state

    @state.setter
    def state(self, value: str | None) -> None:
        if self.manager is not None:
            self.manager.state = value
        else:
            self._own_state = value
