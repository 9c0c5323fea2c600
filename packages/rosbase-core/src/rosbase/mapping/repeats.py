"""Find JSON objects that have a key twice. Decoders silently keep the last one."""

import json
from collections.abc import Iterator
from typing import Any

__all__ = ["OF_NUMBERS", "known_forms", "repeated_key"]

OF_NUMBERS = b"0123456789.-+eE"
"""The characters of numbers. Without them, all messages of a stream have the same form."""

known_forms: set[bytes] = set()
"""Forms of messages without a key twice."""

_MOST_FORMS = 64
_LONGEST_FORM = 4096


def repeated_key(frame: bytes, payload: Any) -> str | None:
    """Return a key that stands twice in an object of a frame, or None.

    Args:
        frame: Valid JSON.
        payload: The same message, decoded.

    Raises:
        RecursionError: It is nested too deeply.
    """
    # Each key has a colon. A text, such as a date, may have one too: then look at each object.
    key = _look_up(frame) if frame.count(b":") > _count_keys(payload) else None
    form = frame.translate(None, OF_NUMBERS)
    if key is None and len(form) <= _LONGEST_FORM and _is_telling(form, payload):
        if len(known_forms) >= _MOST_FORMS:
            known_forms.clear()
        known_forms.add(form)
    return key


class _RepeatedError(Exception):
    """Ends the decoding at a key that an object has twice."""


def _look_up(frame: bytes) -> str | None:
    try:
        json.loads(frame.decode(), object_pairs_hook=_refuse)
    except _RepeatedError as error:
        return str(error)
    return None


def _refuse(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        keys = [key for key, _ in pairs]
        raise _RepeatedError(next(key for key in keys if keys.count(key) > 1))
    return made


def _count_keys(payload: Any) -> int:
    return sum(len(found) for found in _objects(payload))


def _is_telling(form: bytes, payload: Any) -> bool:
    """Return whether the form proves it: whether keys differ in more than digits."""
    if b"\\" in form:
        return False
    removed = str.maketrans("", "", OF_NUMBERS.decode())
    return all(len({key.translate(removed) for key in o}) == len(o) for o in _objects(payload))


def _objects(payload: Any) -> Iterator[dict[str, Any]]:
    """Return all objects in a payload, however deep."""
    waiting = [payload]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            yield value
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value
