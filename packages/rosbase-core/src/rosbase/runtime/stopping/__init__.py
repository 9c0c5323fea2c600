"""Ctrl-C, SIGTERM and SIGHUP as requests to stop, and an end for code that does not return."""

from rosbase.runtime.stopping.interrupt import Interrupt
from rosbase.runtime.stopping.limit import limit_real_time
from rosbase.runtime.stopping.signals import StopSignals, stop_on_signals
from rosbase.runtime.stopping.wishes import Wishes

__all__ = [
    "Interrupt",
    "StopSignals",
    "Wishes",
    "limit_real_time",
    "stop_on_signals",
]
