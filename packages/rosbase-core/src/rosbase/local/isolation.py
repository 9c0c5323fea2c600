"""Requests and answers that can be changed: whoever gets one gets a copy."""

import copy
from collections.abc import Callable
from typing import Any

from rosbase.messages.fields import is_frozen

__all__ = ["isolation"]


def isolation(kind: Any) -> Callable[[Any], Any]:
    """Return a function that copies objects of a class if they can be changed, and no others.

    Programs for rclpy fill one object again and again, and it may wait to be handled or sent.
    """
    return _same if is_frozen(kind) else copy.deepcopy


def _same(value: Any) -> Any:
    return value
