"""Name the keyword arguments that no constructor takes, so that none is lost without a word."""

import difflib
import inspect
from collections.abc import Callable, Iterable
from types import CodeType
from typing import Any

__all__ = ["warn_of_untaken"]


def warn_of_untaken(
    names: Iterable[str],
    classes: Iterable[object],
    own: Callable[..., object],
    warn: Callable[[str], object],
) -> None:
    """Warn of each keyword argument that no constructor names.

    Args:
        names: The keyword arguments.
        classes: Classes to which they are forwarded.
        own: The class that takes the others.
        warn: Called with a line for each.
    """
    for name, similar in _find_untaken(names, classes, inspect.signature(own).parameters).items():
        hint = f"; did you mean {similar}?" if similar else ""
        warn(f"nothing takes the keyword argument {name}{hint}")


def _find_untaken(
    names: Iterable[str], classes: Iterable[object], own: Iterable[str]
) -> dict[str, str]:
    """Find keyword arguments that no constructor names: most likely they are misspelt.

    Args:
        names: The keyword arguments.
        classes: Classes to which they are forwarded.
        own: The parameters of the manager or standalone node itself.

    Returns:
        For each such argument, a similar name that something takes; empty if there is none.
    """
    known = set(own)
    for one in classes:
        for home in inspect.getmro(one) if inspect.isclass(one) else (one,):
            init: Any = home.__dict__.get("__init__") if inspect.isclass(home) else home
            known |= _names_in(getattr(inspect.unwrap(init), "__code__", None) if init else None)
    untaken = [name for name in names if name not in known]
    return {name: _similar(name, known) for name in untaken}


def _similar(name: str, known: Iterable[str]) -> str:
    """Return the known name that has all words of this one, or else almost its letters."""
    words = {*name.split("_")}
    longer = [one for one in known if words < {*one.split("_")}]
    near = sorted(longer, key=lambda one: (len(one), one))
    near = near or difflib.get_close_matches(name, known, 1, 0.75)
    return near[0] if near else ""


def _names_in(code: CodeType | None) -> set[str]:
    """Return the parameters, and the names in texts such as `kwargs.get("goal")`."""
    if code is None:
        return set()
    count = code.co_argcount + code.co_kwonlyargcount
    names = {*code.co_varnames[:count]}
    for constant in code.co_consts:
        if isinstance(constant, str):
            names.add(constant)
        elif isinstance(constant, CodeType):
            names |= _names_in(constant)
    return names
