"""Recordings for rosbase: MCAP files, written while a program runs, and mended if it was killed."""
