"""The reasons for which frames are refused, as a table in Markdown, made from the code."""

from generators.capabilities import table
from rosbase.imu.rejects import IGNORED, REASONS

__all__ = ["reasons"]


def reasons() -> str:
    """Return a table of every reason."""
    rows = [
        [f"`{reason}`", meaning, "ignored" if reason in IGNORED else "rejected"]
        for reason, meaning in sorted(REASONS.items())
    ]
    return table(["reason", "what it means", "counted as"], rows)
