"""The managed lifecycle of ROS 2: a table, and a machine that follows it. Pure."""

from rosbase.lifecycle.machine import Machine, TransitionEvent
from rosbase.lifecycle.managed import ManagedNode
from rosbase.lifecycle.table import (
    CALLBACKS,
    RAISE_ERROR_LABEL,
    TRANSITIONS,
    CallbackReturn,
    State,
    Transition,
    starting_at,
)

__all__ = [
    "CALLBACKS",
    "RAISE_ERROR_LABEL",
    "TRANSITIONS",
    "CallbackReturn",
    "Machine",
    "ManagedNode",
    "State",
    "Transition",
    "TransitionEvent",
    "starting_at",
]
