"""Framers: bytes in, frames out. Pure, so that each can be tested with every chunking."""

from rosbase.framing.events import Frame, FrameError, FrameEvent, Framer
from rosbase.framing.lines import DEFAULT_MAX_LINE_BYTES, LineFramer

__all__ = [
    "DEFAULT_MAX_LINE_BYTES",
    "Frame",
    "FrameError",
    "FrameEvent",
    "Framer",
    "LineFramer",
]
