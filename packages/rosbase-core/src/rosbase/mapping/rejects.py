"""Why a payload does not become a sample: one word each for counting, and a hint for people."""

from attrs import frozen

__all__ = ["PAYLOAD_REASONS", "Reject"]

PAYLOAD_REASONS: dict[str, str] = {
    "bad_json": "not valid JSON",
    "bad_quaternion": "the orientation is not a unit quaternion; is the order right?",
    "incomplete": "part of a vector is missing; see mapping.absent",
    "missing_group": "a required quantity is missing",
    "multi_line": "JSON spread over several lines; print each sample on one line",
    "non_finite": "NaN or infinity",
    "not_data": "plain text, such as a boot message",
    "not_selected": "another kind of message on the same stream",
    "not_utf8": "bytes that are not text; check the baud rate",
    "out_of_range": "a number too large to be one",
    "surplus": "a list holds more of the same than is read; use [*], or a condition",
    "time_unusable": "the device's time is no date; the sample is stamped on arrival",
    "too_deep": "nested too deeply",
    "uneven": "lists of different length in one message",
    "wrong_type": "something else where a number is due",
}
"""The reasons of the mapping language, with what each means or what to check."""


@frozen
class Reject:
    """A frame that is dropped."""

    reason: str
    """One of the REASONS of the device that is read."""
    detail: str = ""
    """What exactly, in half a line; may be empty."""
