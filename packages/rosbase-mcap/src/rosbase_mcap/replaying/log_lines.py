"""The part of a line of the log that a replay must repeat. Pure."""

import re

from rosbase.contracts.message_format import message_format
from rosbase.errors import WireError
from rosbase.messages.rcl_interfaces import Log

__all__ = ["comparable_line"]

# Of an object without a name: `<Gait object at 0x7f3a5c10>`. Any other number is the program's.
_ADDRESS = re.compile(r"(?<= at )0x[0-9a-fA-F]{6,16}\b")
_BELOW = re.compile(r"\n\s*(?:\+ Exception Group )?(?:Traceback|Stack) \(most recent call last\):")
_decode = message_format(Log).decode


def comparable_line(data: bytes) -> dict[str, object] | None:
    """Return the fields of a line that two runs have in common; None if it is no line.

    The place in the source and the traceback are left out, and addresses of objects are masked:
    they differ between two runs, or between versions of Python.

    Args:
        data: The message of the type `rcl_interfaces/msg/Log`.
    """
    try:
        line = _decode(data)
    except WireError:
        return None
    return {
        "stamp.sec": line.stamp.sec,
        "stamp.nanosec": line.stamp.nanosec,
        "level": line.level,
        "name": line.name,
        "msg": _ADDRESS.sub("0x...", _BELOW.split(line.msg, maxsplit=1)[0]),
    }
