"""Find a component by its class, so that type checkers know what it has."""

from collections.abc import Mapping
from typing import TypeVar

from rosbase.parameters import did_you_mean

__all__ = ["find_component"]

ComponentT = TypeVar("ComponentT")


def find_component(
    components: Mapping[str, object],
    component_class: type[ComponentT],
    name: str | None,
    role: str,
) -> ComponentT:
    """Return the component of a class: the only one, or the one of that name.

    Args:
        components: The components of the role by name.
        component_class: Its class, or a base of it.
        name: Its name, needed only if several components are of the class.
        role: `node` or `agent`, for errors.

    Raises:
        LookupError: There is none, the one of that name is of another class, or several are of
            the class and no name is given.
    """
    if not isinstance(component_class, type):
        raise TypeError(f"{role}() takes a class, and then perhaps a name; not {component_class!r}")
    if name is None and (only := _only_one(components, component_class)) is not None:
        return only
    wanted = component_class.__name__
    if name is not None:
        named = components.get(name)
        if isinstance(named, component_class):
            return named
        if name in components:
            raise LookupError(f"{role} {name!r} is of class {type(named).__name__}, not {wanted}")
        hint = did_you_mean(name, components)
        raise LookupError(f"no {role} is named {name!r}; {_registered(components)}{hint}")
    names = [key for key, it in components.items() if isinstance(it, component_class)]
    if not names:
        raise LookupError(f"no {role} is of class {wanted}; {_registered(components)}")
    *others, last = map(repr, names)
    raise LookupError(
        f"{', '.join(others)} and {last} are of class {wanted}; "
        f"choose one, as in {role}({wanted}, {names[0]!r})"
    )


def _only_one(
    components: Mapping[str, object], component_class: type[ComponentT]
) -> ComponentT | None:
    """Return the only component of a class; None if there is none, or several."""
    # In a loop, which takes half as long as a list: programs ask several times in a tick.
    found = None
    for component in components.values():
        if isinstance(component, component_class):
            if found is not None:
                return None
            found = component
    return found


def _registered(components: Mapping[str, object]) -> str:
    known = ", ".join(f"{name!r} ({type(it).__name__})" for name, it in components.items())
    return f"registered: {known}" if known else "none is registered"
