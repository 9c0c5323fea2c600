"""Checks: methods whose names are promises."""

import inspect
from collections.abc import Callable

from rosbase.testing.promise import Promise

__all__ = ["promise_of", "promises_of"]

_PREFIX = "test_"


def promise_of(check: Callable[..., object], page: str) -> Promise:
    """Return the promise that a check tests.

    Its name is the method's, with hyphens; its sentence is the docstring.
    """
    name = check.__name__.removeprefix(_PREFIX).replace("_", "-")
    return Promise(name, " ".join((inspect.getdoc(check) or "").split()), page)


def promises_of(contract: type) -> tuple[Promise, ...]:
    """Return all promises that a contract checks, in the order of the source."""
    methods = {
        name: method
        for base in reversed(contract.__mro__)
        for name, method in vars(base).items()
        if name.startswith(_PREFIX)
    }
    return tuple(method.promise for method in methods.values())
