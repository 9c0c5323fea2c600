"""Compute something once for each class."""

import functools
from collections.abc import Callable
from typing import Any, TypeVar, cast

__all__ = ["once_per_class"]

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])


def once_per_class(function: FunctionT) -> FunctionT:
    """Keep the result for each class. `functools.cache` alone would lose the types."""
    return cast("FunctionT", functools.cache(function))
