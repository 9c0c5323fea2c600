"""Reasons why a frame does not become a message: a word for counting, and a hint for people."""

from rosbase.mapping.rejects import PAYLOAD_REASONS

__all__ = ["IGNORED", "NO_SIGN_OF_LIFE", "REASONS", "REJECT_LOG_S", "SAID_BEFORE", "meaning_of"]

REJECT_LOG_S = 5.0
"""Minimum seconds between two log lines about the same reason."""

REASONS: dict[str, str] = {
    **PAYLOAD_REASONS,
    "bad_checksum": "the checksum does not fit the line",
    "bad_topic": "a topic that MQTT does not allow; see how the device names it",
    "duplicate": "delivered once more",
    "empty": "nothing in it",
    "frozen": "the same numbers again and again; does the sensor hang?",
    "implausible": "gravity is not what it should be at rest; is the unit right?",
    "implausible_date": "a date far from all others",
    "implausible_orientation": "gravity at rest is not where the orientation has it",
    "no_checksum": "a line without the checksum that it should have",
    "late": "waited while nothing was read; its arrival time is unknown",
    "no_frame": "bytes, and no frame among them; does it send more than blank lines?",
    "no_imu_data": "nothing that the mapping knows; is the preset right?",
    "not_active": "the node is not active",
    "not_sent": "the backend did not take it; its log says why",
    "other_topic": "of another device under the same wildcard",
    "out_of_order": "dated before one that has been published",
    "overlong": "too long for a sample",
    "retained": "kept by the broker from an earlier time",
    "unended": "bytes without an end of line",
}
"""Every reason, with its meaning or a hint what to check."""

IGNORED = frozenset(
    {"duplicate", "not_active", "not_data", "not_selected", "other_topic", "retained"}
)
"""Reasons that are no fault of the device."""

SAID_BEFORE = frozenset({"late"})
"""Reasons that the transport's log explains better."""

NO_SIGN_OF_LIFE = frozenset({"bad_topic", "other_topic", "retained"})
"""Reasons that say nothing about the device that is read: neither that it lives, nor what it sends.
"""


def meaning_of(reason: str) -> str:
    """Return the meaning of a reason; empty for a transport's own reason."""
    return REASONS.get(reason, "")
