"""Run the programs of a file in the panes of tmux."""

from rosbase.launcher.tmux.start import start_in_tmux

__all__ = ["start_in_tmux"]
