"""Build components from classes, and check that their constructors did their part."""

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from rosbase.logger import RosbaseLogger
from rosbase.roles.callables import check_methods
from rosbase.roles.classes import check_class
from rosbase.roles.construction import Constructed
from rosbase.roles.context import Component
from rosbase.roles.registration import Registration

__all__ = ["Builder"]

ComponentT = TypeVar("ComponentT")


class Builder:
    """Builds the components of one manager."""

    def __init__(
        self,
        manager: object,
        registration: Registration,
        logger: RosbaseLogger,
        args: tuple[Any, ...],
        kwargs: Mapping[str, Any],
    ) -> None:
        """Prepare to build.

        Args:
            manager: Given to each component as `manager`.
            registration: Gives each component its key.
            logger: Logs what a constructor has left out.
            args: Forwarded to each component as they are.
            kwargs: Forwarded as they are.
        """
        self._manager = manager
        self._registration = registration
        self._logger = logger
        self._args = args
        self._kwargs = kwargs

    def build(
        self,
        component: Callable[..., ComponentT],
        where: str,
        key: str,
        plain_methods: tuple[str, ...],
    ) -> ComponentT:
        """Build a component.

        Args:
            component: Its class, or a function that makes one.
            where: Place where the program names it, for errors, such as `nodes_dict['camera']`.
            key: Its name in that place; empty if there is none.
            plain_methods: Methods that rosbase calls, if it is no class of rosbase.

        Raises:
            TypeError: It is an instance instead of a class, or lacks a call of its base class's
                constructor without which it cannot work, or a method is async or a generator.
        """
        self._registration.begin(key, component)
        built = self._construct(component, where)
        self._registration.end()
        if lack := _lacks_its_base(built):
            self._logger.warning(lack)
        # Again, because a constructor may have put another function in its place.
        check_methods(
            built, built._plain_methods if isinstance(built, Component) else plain_methods
        )
        return built

    def _construct(self, component: Callable[..., ComponentT], where: str) -> ComponentT:
        check_class(component, where)
        args, kwargs = self._args, self._kwargs
        # By name, because components may take it from their keyword arguments; but Python
        # has no place for positional ones after a named first.
        built = (
            component(self._manager, *args, **kwargs)
            if args
            else component(manager=self._manager, **kwargs)
        )
        if isinstance(built, Constructed) and (lack := built._missing_base()):
            # Its class has got its constructor later, as from `dataclass`.
            raise TypeError(lack)
        return built


def _lacks_its_base(built: object) -> str:
    """Say that a component's constructor has not called its base class's; empty if it has.

    A component that uses nothing of rosbase may do without.
    """
    if not isinstance(built, Component) or built._is_initialised:
        return ""
    name = type(built).__name__
    return (
        f"{name}.__init__ does not call super().__init__(manager, *args, **kwargs): "
        "it has no manager, no logger and no topics"
    )
