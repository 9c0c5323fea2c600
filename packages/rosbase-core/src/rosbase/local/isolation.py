"""Requests and answers that can be changed: whoever gets one gets a copy."""

import copy
from collections.abc import Callable
from typing import Any

from rosbase.messages.fields import is_frozen

__all__ = ["isolated"]


def isolated(make: Callable[[Any], Any], kind: Any) -> Callable[[Any], Any]:
    """Return a function that returns copies of what another one returns, if they can be changed.

    Programs for rclpy fill one object again and again, and it may wait to be handled or sent.

    Args:
        make: The function; it is returned itself if there is nothing to copy.
        kind: The class of its results.
    """
    return make if is_frozen(kind) else lambda given: copy.deepcopy(make(given))
