"""Names that users give to a reader: of its topics, and of the frame of its sensor."""

from rosbase.contracts.names import resolve_topic
from rosbase.errors import BackendError, ParameterError

__all__ = ["check_names"]

# The longest of the three; what makes one of them wrong is in the namespace.
_LONGEST_TOPIC = "data_raw"


def check_names(topic_namespace: str, frame_id: str, node_name: str) -> None:
    """Refuse names that ROS would refuse, on every backend and before a device is opened.

    Args:
        topic_namespace: Parameter `topic_namespace`.
        frame_id: Parameter `frame_id`.
        node_name: The name of the node, its namespace in front if there is one.

    Raises:
        ParameterError: One of them is invalid; the message says why.
    """
    try:
        resolve_topic(f"{topic_namespace}/{_LONGEST_TOPIC}", node_name)
    except BackendError as error:
        raise ParameterError(f"parameter topic_namespace: {error}") from error
    if fault := _frame_fault(frame_id):
        raise ParameterError(f"parameter frame_id: {frame_id!r} {fault}")


def _frame_fault(frame_id: str) -> str:
    """Return why tf2 or DDS refuses a frame name; empty if not (tf2: `validateFrameId`)."""
    if not frame_id:
        return "is empty, and tf2 takes no empty frame"
    if frame_id.startswith("/"):
        return f"starts with /, and tf2 takes no such frame; did you mean {frame_id.lstrip('/')}?"
    try:
        frame_id.encode()
    except UnicodeEncodeError:
        return "is not UTF-8 text, which ROS cannot send"
    return ""
