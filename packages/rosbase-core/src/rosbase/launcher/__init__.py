"""The launcher: start the programs of a file in order, watch them, and stop them together."""

from rosbase.launcher.base_launcher import BaseLauncher

__all__ = ["BaseLauncher"]
