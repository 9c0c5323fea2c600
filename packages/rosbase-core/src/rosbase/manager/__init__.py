"""The manager, with one module for each of its duties."""

from rosbase.manager.base_manager import BaseManager
from rosbase.processes import register_multiprocess_nodes, shutdown_multiprocess_nodes

__all__ = ["BaseManager", "register_multiprocess_nodes", "shutdown_multiprocess_nodes"]
