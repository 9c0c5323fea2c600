"""The terminal of a run: lines of output, and the states of the programs."""

from rosbase.launcher.display.terminal import Terminal

__all__ = ["Terminal"]
