"""Build components from classes, and check that their constructors did their part."""

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from rosbase.roles.classes import check_class
from rosbase.roles.construction import Constructed
from rosbase.roles.context import Component

__all__ = ["build", "lacks_its_base"]

ComponentT = TypeVar("ComponentT")


def build(
    component: Callable[..., ComponentT],
    where: str,
    manager: object,
    args: tuple[Any, ...],
    kwargs: Mapping[str, Any],
) -> ComponentT:
    """Build a component of a manager.

    Args:
        component: Its class, or a function that makes one.
        where: Place where the program names it, for errors, such as `nodes_dict['camera']`.
        manager: Given to it as `manager`.
        args: Forwarded as they are.
        kwargs: Forwarded as they are.

    Raises:
        TypeError: It is an instance instead of a class, or lacks a call of its base class's
            constructor without which it cannot work.
    """
    check_class(component, where)
    # By name, because components may take it from their keyword arguments; but Python
    # has no place for positional ones after a named first.
    built = component(manager, *args, **kwargs) if args else component(manager=manager, **kwargs)
    if isinstance(built, Constructed) and (lack := built._missing_base()):
        # Its class has got its constructor later, as from `dataclass`.
        raise TypeError(lack)
    return built


def lacks_its_base(built: object) -> str:
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
