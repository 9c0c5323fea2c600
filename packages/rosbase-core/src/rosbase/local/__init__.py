"""The backend of the core: everything in one process, nothing to install."""

from rosbase.local.backend import LocalBackend
from rosbase.local.bus import Bus, process_bus

__all__ = ["Bus", "LocalBackend", "process_bus"]
