"""Contents of entries that come from outside: bytes, or a function that makes them later."""

import json
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

__all__ = ["Json", "Payload", "as_bytes", "from_json", "to_json"]

Json: TypeAlias = "bool | int | float | str | Sequence[Json] | Mapping[str, Json] | None"
"""Any value that JSON can carry. Tuples come back as lists."""

Payload: TypeAlias = bytes | Callable[[], bytes]
"""The bytes, or a function that the writer of the file calls for them, on its own thread.

A message that can change must be encoded at once.
"""


def as_bytes(payload: Payload) -> bytes:
    """Return the bytes of a payload."""
    return payload if isinstance(payload, bytes) else payload()


def to_json(value: Json) -> bytes:
    """Return a value as JSON. Floats come back equal, also those that are not finite."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False).encode(
        "utf-8", "surrogatepass"
    )


def from_json(data: bytes) -> Json:
    """Return the value of some JSON.

    Raises:
        ValueError: It is not JSON.
    """
    value: Json = json.loads(data.decode("utf-8", "surrogatepass"))
    return value
