"""Call sites: the places in a program that log."""

import sys
from types import FrameType

__all__ = ["CallSite", "calling_frame", "site_of"]

CallSite = tuple[str, str, int, int]
"""File, function, line and instruction: two calls in one line are two places, as in rclpy."""

_PACKAGE = __package__


def calling_frame(stacklevel: int = 1) -> FrameType:
    """Return the innermost frame outside of this package, or one further out, as in `logging`."""
    frame = sys._getframe()
    while frame.f_back is not None and frame.f_globals.get("__package__") == _PACKAGE:
        frame = frame.f_back
    while frame.f_back is not None and stacklevel > 1:
        frame = frame.f_back
        stacklevel -= 1
    return frame


def site_of(frame: FrameType) -> CallSite:
    """Return the place where a frame is."""
    return frame.f_code.co_filename, frame.f_code.co_name, frame.f_lineno, frame.f_lasti
