"""A framework for robot applications: four roles and a managed lifecycle, with or without ROS."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rosbase.agent import BaseAgent
    from rosbase.handlers import BaseHandlers
    from rosbase.lifecycle import CallbackReturn, State
    from rosbase.lifecycle_node import LifecycleNode
    from rosbase.manager import BaseManager
    from rosbase.node import BaseNode
    from rosbase.processes import (
        RestartPolicy,
        register_multiprocess_nodes,
        shutdown_multiprocess_nodes,
    )
    from rosbase.qos import (
        DurabilityPolicy,
        HistoryPolicy,
        QoSProfile,
        ReliabilityPolicy,
        qos_profile_sensor_data,
    )

__all__ = [
    "BaseAgent",
    "BaseHandlers",
    "BaseManager",
    "BaseNode",
    "CallbackReturn",
    "DurabilityPolicy",
    "HistoryPolicy",
    "LifecycleNode",
    "QoSProfile",
    "ReliabilityPolicy",
    "RestartPolicy",
    "State",
    "qos_profile_sensor_data",
    "register_multiprocess_nodes",
    "shutdown_multiprocess_nodes",
]

_HOMES = {
    "BaseAgent": "rosbase.agent",
    "BaseHandlers": "rosbase.handlers",
    "BaseManager": "rosbase.manager",
    "BaseNode": "rosbase.node",
    "CallbackReturn": "rosbase.lifecycle",
    "DurabilityPolicy": "rosbase.qos",
    "HistoryPolicy": "rosbase.qos",
    "LifecycleNode": "rosbase.lifecycle_node",
    "QoSProfile": "rosbase.qos",
    "ReliabilityPolicy": "rosbase.qos",
    "RestartPolicy": "rosbase.processes",
    "State": "rosbase.lifecycle",
    "qos_profile_sensor_data": "rosbase.qos",
    "register_multiprocess_nodes": "rosbase.processes",
    "shutdown_multiprocess_nodes": "rosbase.processes",
}


def __getattr__(name: str) -> Any:
    """Imports each name when it is first asked for, so that the command line starts at once."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value
