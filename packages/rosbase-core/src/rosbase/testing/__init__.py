"""For the tests of programs and plugins. Nothing of rosbase itself imports it."""

from rosbase.testing.backend import virtual_backend
from rosbase.testing.clock import ManualClock
from rosbase.testing.promise import BrokenPromiseError, Promise

__all__ = ["BrokenPromiseError", "ManualClock", "Promise", "virtual_backend"]
