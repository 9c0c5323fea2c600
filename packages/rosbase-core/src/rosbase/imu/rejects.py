"""Why a frame does not become a message: one word each for counting, and a hint for people."""

from attrs import frozen

__all__ = ["IGNORED", "REASONS", "Reject"]

REASONS: dict[str, str] = {
    "bad_json": "not valid JSON",
    "bad_quaternion": "the orientation is not a unit quaternion; is the order right?",
    "duplicate": "delivered once more",
    "empty": "nothing in it",
    "implausible": "gravity is not what it should be at rest; is the unit right?",
    "incomplete": "part of a vector is missing",
    "missing_group": "a required quantity is missing",
    "multi_line": "JSON spread over several lines; print each sample on one line",
    "no_imu_data": "nothing that the mapping knows; is the preset right?",
    "non_finite": "NaN or infinity",
    "not_active": "the node is not active",
    "not_data": "plain text, such as a boot message",
    "not_selected": "another kind of message on the same stream",
    "not_utf8": "bytes that are not text; check the baud rate",
    "other_topic": "of another device under the same wildcard",
    "out_of_order": "dated before one that has been published",
    "out_of_range": "a number too large to be one",
    "overlong": "too long for a sample; is it the right device and baud rate?",
    "retained": "kept by the broker from an earlier time",
    "too_deep": "nested too deeply",
    "wrong_type": "something else where a number is due",
}
"""Every reason, with what it means or what to check."""

IGNORED = frozenset(
    {"duplicate", "not_active", "not_data", "not_selected", "other_topic", "retained"}
)
"""Reasons that are no fault of the device."""


@frozen
class Reject:
    """A frame that is dropped."""

    reason: str
    """One of REASONS."""
    detail: str = ""
    """What exactly, in half a line; may be empty."""
