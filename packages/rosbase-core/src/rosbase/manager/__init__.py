"""The manager, with each of its duties in a place of its own."""

from rosbase.manager.base_manager import BaseManager

__all__ = ["BaseManager"]
