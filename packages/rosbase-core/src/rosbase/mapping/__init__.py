"""The mapping language: a payload described as data, for any device."""

from rosbase.mapping.assembly import Batch, Row
from rosbase.mapping.description import LARGEST, Quantity, TimeMapping
from rosbase.mapping.payload_mapping import PayloadMapping
from rosbase.mapping.payload_reading import FrameReader
from rosbase.mapping.quantities import Numbers
from rosbase.mapping.rejects import PAYLOAD_REASONS, Reject

__all__ = [
    "LARGEST",
    "PAYLOAD_REASONS",
    "Batch",
    "FrameReader",
    "Numbers",
    "PayloadMapping",
    "Quantity",
    "Reject",
    "Row",
    "TimeMapping",
]
