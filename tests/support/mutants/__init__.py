"""Transports that each break one promise, and are otherwise as good as can be."""

from support.mutants import (
    calls,
    delivery,
    frames,
    health,
    losses,
    resources,
    stamps,
    unfinished,
)
from support.mutants.mutant import LEAKED, MUTANTS, RELEASE, Mutant

__all__ = [
    "LEAKED",
    "MUTANTS",
    "RELEASE",
    "Mutant",
    "calls",
    "delivery",
    "frames",
    "health",
    "losses",
    "resources",
    "stamps",
    "unfinished",
]
