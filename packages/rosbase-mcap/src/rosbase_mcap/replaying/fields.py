"""The fields in which two messages differ, as lines for people. Pure."""

from collections.abc import Mapping
from typing import Any

from attrs import frozen

from rosbase.errors import WireError
from rosbase.text.printable import printable
from rosbase.wire.plain import decoder
from rosbase_mcap.channel_table import ROS2MSG
from rosbase_mcap.records import Schema
from rosbase_mcap.replaying.log_lines import comparable_line

__all__ = ["LOG", "Changes", "FieldChange", "changes"]

LOG = "rcl_interfaces/msg/Log"
"""Type of the lines of the log, of which only a part is compared."""
_BUFFERS = (memoryview, bytes)
_ARRAYS = (tuple, list, *_BUFFERS)
# As many elements of one array are named, or bytes shown.
_MOST = 10
_NOTHING = "nothing"


@frozen
class FieldChange:
    """A field with another value."""

    field: str
    """Its name, such as `position[2]` or `angular_velocity.x`; or `byte 12`."""
    before: str
    """Its value in the recording."""
    after: str
    """Its value in the replay."""

    def __str__(self) -> str:
        """Return it as a line."""
        return f"{self.field}: {printable(self.before)} -> {printable(self.after)}"


@frozen
class Changes:
    """The differences between two messages."""

    fields: tuple[FieldChange, ...]
    equal: int
    """How many other fields are equal; an array is one field."""


def changes(before: bytes, after: bytes, old: Schema | None, new: Schema | None) -> Changes:
    """Return what differs between two messages, which is nothing if a replay need not repeat it.

    Numbers are compared as they are written, so 0.0 is not -0.0, and NaN is NaN.

    Args:
        before: The recorded message.
        after: The replayed one.
        old: Schema of the recorded one; None if it is unknown.
        new: Schema of the replayed one.
    """
    if before == after:
        return Changes((), 1)
    names = old.name if old else "", new.name if new else ""
    if names[0] != names[1]:
        return Changes((FieldChange("type", *names),), 0)
    pair = _read(before, old), _read(after, new)
    if pair[0] is None or pair[1] is None:
        return Changes((_as_bytes(before, after),), 0)
    walk = _Walk()
    walk.compare(*pair, "")
    if not walk.found and names[0] != LOG:
        # Something that no field shows, such as the padding between two of them.
        walk.found.append(_as_bytes(before, after))
    return Changes(tuple(walk.found), walk.equal)


def _as_bytes(before: bytes, after: bytes) -> FieldChange:
    pairs = enumerate(zip(before, after, strict=False))
    shorter = min(len(before), len(after))
    at = next((at for at, pair in pairs if pair[0] != pair[1]), shorter)
    texts = (data[at : at + _MOST].hex(" ") or _NOTHING for data in (before, after))
    return FieldChange(f"byte {at}", *texts)


def _read(data: bytes, schema: Schema | None) -> dict[str, Any] | None:
    """Return the fields of a message; None if it cannot be read."""
    if schema is None or schema.encoding != ROS2MSG:
        return None
    if schema.name == LOG:
        return comparable_line(data)
    try:
        return decoder(schema.name, str(schema.data, "utf-8", "replace"))(data)
    except WireError:
        return None


class _Walk:
    """Goes through two messages at once."""

    def __init__(self) -> None:
        self.found: list[FieldChange] = []
        self.equal = 0

    def compare(self, one: Any, other: Any, name: str) -> None:
        """Note in what two values differ."""
        if isinstance(one, Mapping) and isinstance(other, Mapping):
            for key in dict.fromkeys([*one, *other]):
                inner = f"{name}.{key}" if name else key
                self.compare(one.get(key, _Nothing()), other.get(key, _Nothing()), inner)
        elif isinstance(one, _ARRAYS) and isinstance(other, _ARRAYS):
            self._arrays(one, other, name)
        else:
            self._values(one, other, name)

    def _arrays(self, one: Any, other: Any, name: str) -> None:
        if len(one) != len(other):
            lengths = (f"{len(array)} elements" for array in (one, other))
            self.found.append(FieldChange(name, *lengths))
            return
        # Large arrays of numbers hardly ever differ.
        if isinstance(one, _BUFFERS) and isinstance(other, _BUFFERS) and bytes(one) == bytes(other):
            self.equal += 1
            return
        before, equal = len(self.found), self.equal
        for number, values in enumerate(zip(one, other, strict=True)):
            self.compare(*values, f"{name}[{number}]")
            if len(self.found) - before >= _MOST:
                break
        # The elements that are equal count as none: others of the array are shown.
        self.equal = equal + (len(self.found) == before)

    def _values(self, one: Any, other: Any, name: str) -> None:
        texts = repr(one), repr(other)
        if texts[0] == texts[1]:
            self.equal += 1
        else:
            self.found.append(FieldChange(name, *texts))


class _Nothing:
    def __repr__(self) -> str:
        return _NOTHING
