"""The manager, with each of its duties in a place of its own."""

from rosbase.manager.base_manager import BaseManager
from rosbase.processes import register_multiprocess_nodes, shutdown_multiprocess_nodes

__all__ = ["BaseManager", "register_multiprocess_nodes", "shutdown_multiprocess_nodes"]
