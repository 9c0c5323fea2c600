"""Backends with one thing wrong each, for the checks of the backend kit to find.

Each is the backend of the core but for what its name says, and is entered under the promise that
it breaks.
"""

from support.backend_mutants import (
    ending,
    opening,
    parameters,
    quality,
    services,
    taps,
    threads,
    timers,
    topics,
)
from support.backend_mutants.changed import LEFT_OPEN, MUTANTS, PATIENCE_S

__all__ = [
    "LEFT_OPEN",
    "MUTANTS",
    "PATIENCE_S",
    "ending",
    "opening",
    "parameters",
    "quality",
    "services",
    "taps",
    "threads",
    "timers",
    "topics",
]
