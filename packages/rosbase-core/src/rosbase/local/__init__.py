"""The backend of the core: everything in one process, nothing to install."""

from rosbase.local.backend import LocalBackend
from rosbase.local.bus import Bus, process_bus
from rosbase.local.link import Link

__all__ = ["Bus", "Link", "LocalBackend", "process_bus"]
