"""Files of the launcher: from text to sessions and programs, with every mistake by its line."""

from rosbase.launcher.description.model import Condition, Description, Program, Session
from rosbase.launcher.description.reading import read_mapping, read_text
from rosbase.launcher.description.tree import Fault, Faults

__all__ = [
    "Condition",
    "Description",
    "Fault",
    "Faults",
    "Program",
    "Session",
    "read_mapping",
    "read_text",
]
