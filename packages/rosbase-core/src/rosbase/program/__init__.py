"""How a program starts: its arguments, its parameters from outside, its manager."""

from rosbase.program.arguments import take_arguments

__all__ = ["take_arguments"]
