"""Stamps: arrival times of the frames of a stream, as far as they can be known. Pure."""

from rosbase.stamps.backlog import LATE_NS
from rosbase.stamps.clock_offset import ClockOffset
from rosbase.stamps.rhythm import Rhythm
from rosbase.stamps.spread import spread
from rosbase.stamps.timeline import Timeline

__all__ = ["LATE_NS", "ClockOffset", "Rhythm", "Timeline", "spread"]
