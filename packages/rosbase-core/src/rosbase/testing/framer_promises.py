"""Promises of a framer."""

from rosbase.testing.promise import Promise

__all__ = [
    "CHUNKING",
    "ERRORS",
    "FRAMER",
    "FRAMER_PROMISES",
    "JUNK",
    "MEMORY",
    "NOT_RAISING",
    "PENDING",
    "REASONS",
    "RESET",
    "SEPARATE",
    "STAMPS",
    "STAMP_ORDER",
    "UNALTERED",
]

_PAGE = "plugins/framer-contract"

FRAMER = Promise(
    "a-framer-is-made",
    "make_framer returns a new framer, with feed and reset, and encode returns bytes.",
    _PAGE,
)
UNALTERED = Promise(
    "frames-come-out-as-they-went-in",
    "Each encoded payload comes out as one frame, byte for byte, in order.",
    _PAGE,
)
CHUNKING = Promise(
    "chunking-does-not-matter",
    "The same bytes give the same frames and the same errors, however they are cut.",
    _PAGE,
)
JUNK = Promise(
    "junk-spoils-few-frames",
    "After junk, few frames are lost or damaged; later frames come out complete, none merged.",
    _PAGE,
)
NOT_RAISING = Promise(
    "any-bytes-may-come",
    "feed takes any bytes, raises nothing, and returns a list of Frame and FrameError.",
    _PAGE,
)
MEMORY = Promise(
    "memory-is-bounded",
    "Bytes that never end a frame do not pile up, and no frame is kept after it came out.",
    _PAGE,
)
ERRORS = Promise(
    "what-is-too-long-is-an-error",
    "Too many bytes for a frame give a FrameError, so no loss is silent.",
    _PAGE,
)
STAMPS = Promise(
    "the-stamp-is-that-of-the-first-bytes",
    "A frame has the stamp with which its first bytes were fed.",
    _PAGE,
)
STAMP_ORDER = Promise(
    "stamps-never-go-back",
    "No event has an earlier stamp than the one before it.",
    _PAGE,
)
RESET = Promise(
    "reset-forgets-a-begun-frame",
    "After reset, new bytes do not continue a frame that was begun.",
    _PAGE,
)
PENDING = Promise(
    "pending-bytes-are-those-since-the-last-end",
    "pending_bytes, if there is one, is the number of bytes fed since a frame ended.",
    _PAGE,
)
REASONS = Promise(
    "an-error-has-a-reason-of-one-word",
    "The reason of a FrameError is one of a few words, so that it can be counted.",
    _PAGE,
)
SEPARATE = Promise(
    "two-framers-share-nothing",
    "Bytes fed to one framer do not change the output of another.",
    _PAGE,
)

FRAMER_PROMISES = (
    *(FRAMER, UNALTERED, CHUNKING, JUNK, NOT_RAISING, MEMORY, ERRORS),
    *(STAMPS, STAMP_ORDER, RESET, PENDING, REASONS, SEPARATE),
)
