"""Replays of recordings: what a file has for them, and what is compared."""
