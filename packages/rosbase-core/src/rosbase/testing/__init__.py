"""For the tests of programs and plugins. Nothing of rosbase itself imports it."""

from rosbase.testing.backend import virtual_backend
from rosbase.testing.clock import ManualClock

__all__ = ["ManualClock", "virtual_backend"]
