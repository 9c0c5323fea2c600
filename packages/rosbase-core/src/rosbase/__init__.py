"""A framework for robot applications: four roles and a managed lifecycle, with or without ROS."""

from rosbase.agent import BaseAgent
from rosbase.handlers import BaseHandlers
from rosbase.lifecycle import CallbackReturn, State
from rosbase.lifecycle_node import LifecycleNode
from rosbase.manager import BaseManager
from rosbase.node import BaseNode

__all__ = [
    "BaseAgent",
    "BaseHandlers",
    "BaseManager",
    "BaseNode",
    "CallbackReturn",
    "LifecycleNode",
    "State",
]
