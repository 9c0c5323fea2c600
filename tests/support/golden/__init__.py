"""Recordings that earlier versions have made, and their programs."""
