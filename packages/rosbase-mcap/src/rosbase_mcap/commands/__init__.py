"""The commands for recordings, a module for each."""
