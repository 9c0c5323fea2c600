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
    # The usual case, in a third of the time: many programs ask several times in a tick.
    if name is None and isinstance(component_class, type):
        only = None
        for component in components.values():
            if isinstance(component, component_class):
                if only is not None:
                    break
                only = component
        else:
            if only is not None:
                return only
    if not isinstance(component_class, type):
        raise TypeError(f"{role}() takes a class, and then perhaps a name; not {component_class!r}")
    wanted = component_class.__name__
    if name is not None:
        named = components.get(name)
        if isinstance(named, component_class):
            return named
        if name in components:
            raise LookupError(f"{role} {name!r} is of class {type(named).__name__}, not {wanted}")
        hint = did_you_mean(name, components)
        raise LookupError(f"no {role} is named {name!r}; {_registered(components)}{hint}")
    found = {key: it for key, it in components.items() if isinstance(it, component_class)}
    if not found:
        raise LookupError(f"no {role} is of class {wanted}; {_registered(components)}")
    if len(found) > 1:
        *others, last = map(repr, found)
        example = f"{role}({wanted}, {next(iter(found))!r})"
        raise LookupError(
            f"{', '.join(others)} and {last} are of class {wanted}; choose one, as in {example}"
        )
    return next(iter(found.values()))


def _registered(components: Mapping[str, object]) -> str:
    known = ", ".join(f"{name!r} ({type(it).__name__})" for name, it in components.items())
    return f"registered: {known}" if known else "none is registered"
