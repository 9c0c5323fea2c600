"""Text from anywhere, as any backend can send it."""

__all__ = ["sendable"]


def sendable(text: str) -> str:
    """The text, with an escape for a NUL, at which ROS would cut, and for half a surrogate pair."""
    return text.replace("\0", "\\0").encode(errors="backslashreplace").decode()
