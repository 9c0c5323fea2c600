"""Packages that import a name when it is used: a message costs a quarter of a millisecond."""

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

__all__ = ["names_of", "on_demand"]


def on_demand(
    module: str, where: Mapping[str, str], home: str = "rosbase.messages"
) -> Callable[[str], Any]:
    """Return a module's `__getattr__`.

    Args:
        module: Name of that module.
        where: The module of each name, below `home`. No module is named like one of the names,
            because Python would find the module in place of the name.
        home: The package of these modules.
    """

    def get(name: str) -> Any:
        if name not in where:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        found = getattr(import_module(f"{home}.{where[name]}"), name)
        setattr(sys.modules[module], name, found)
        return found

    return get


def names_of(names: Sequence[str]) -> Callable[[], list[str]]:
    """Return a module's `__dir__`."""
    return lambda: sorted(names)
