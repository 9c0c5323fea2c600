"""What a framer promises."""

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
    "make_framer gives a new framer, with feed and reset, and encode gives bytes.",
    _PAGE,
)
UNALTERED = Promise(
    "frames-come-out-as-they-went-in",
    "What has been encoded comes out as one frame each, byte for byte, in order.",
    _PAGE,
)
CHUNKING = Promise(
    "chunking-does-not-matter",
    "The same bytes give the same frames and the same errors, however they are cut.",
    _PAGE,
)
JUNK = Promise(
    "junk-spoils-few-frames",
    "After junk, few frames are lost or spoiled; the next ones come out whole, none merged.",
    _PAGE,
)
NOT_RAISING = Promise(
    "any-bytes-may-come",
    "feed takes any bytes, raises nothing, and gives a list of Frame and FrameError.",
    _PAGE,
)
MEMORY = Promise(
    "memory-is-bounded",
    "Neither bytes that never end a frame pile up, nor frames that have come out.",
    _PAGE,
)
ERRORS = Promise(
    "what-is-too-long-is-an-error",
    "Bytes that are too many for a frame give a FrameError: what is lost is not lost in silence.",
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
    "After reset, what comes next does not continue what was begun.",
    _PAGE,
)
PENDING = Promise(
    "pending-bytes-are-those-since-the-last-end",
    "pending_bytes, where there is one, says how many bytes were fed since a frame ended.",
    _PAGE,
)
REASONS = Promise(
    "an-error-has-a-reason-of-one-word",
    "The reason of a FrameError is one word, from a few, so that it can be counted.",
    _PAGE,
)
SEPARATE = Promise(
    "two-framers-share-nothing",
    "What one framer is fed does not change what another gives.",
    _PAGE,
)

FRAMER_PROMISES = (
    *(FRAMER, UNALTERED, CHUNKING, JUNK, NOT_RAISING, MEMORY, ERRORS),
    *(STAMPS, STAMP_ORDER, RESET, PENDING, REASONS, SEPARATE),
)
