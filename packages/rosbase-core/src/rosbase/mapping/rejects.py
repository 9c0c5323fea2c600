"""The reasons to refuse a payload: a word for the counts, and a hint for people."""

from attrs import frozen

__all__ = ["PAYLOAD_REASONS", "Reject"]

PAYLOAD_REASONS: dict[str, str] = {
    "bad_json": "not valid JSON",
    "bad_quaternion": "the orientation is not a unit quaternion; is the order right?",
    "incomplete": "part of a vector is missing; see mapping.absent",
    "missing_group": "a required quantity is missing",
    "multi_line": "JSON spread over several lines; print each sample on one line",
    "non_finite": "NaN or infinity",
    "not_data": "text that is not JSON",
    "not_selected": "another kind of message on the same stream",
    "not_utf8": "bytes that are not text",
    "out_of_range": "a number beyond the full scale; is the unit right?",
    "surplus": "a list holds more of the same than is read; use [*], or a condition",
    "time_unusable": "the device's time is no date; the sample is stamped on arrival",
    "too_deep": "nested too deeply",
    "uneven": "lists of different length in one message",
    "wrong_type": "something other than a number in a number's place",
}
"""The reasons of the mapping language, each with its meaning or a hint."""


@frozen
class Reject:
    """The reason to refuse a frame, or to leave a quantity out of a sample."""

    reason: str
    """One word, such as those in PAYLOAD_REASONS."""
    detail: str = ""
    """The details in half a line; may be empty."""
