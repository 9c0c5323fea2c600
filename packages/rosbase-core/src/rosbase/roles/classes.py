"""Classes of components, as programs give them to managers and child processes."""

from rosbase.roles.context import Component

__all__ = ["check_class"]


def check_class(component: object, where: str) -> None:
    """Refuse an instance where a class, or a function that makes a component, belongs.

    Args:
        component: The value that the program gave.
        where: Place where the program gave it, such as `nodes_dict['camera']`.

    Raises:
        TypeError: It is an instance, or cannot be called.
    """
    if isinstance(component, Component):
        name = type(component).__name__
        raise TypeError(f"{where} is an instance of {name}; give the class, {name}")
    if not callable(component):
        raise TypeError(f"{where} is {component!r}; give a class")
