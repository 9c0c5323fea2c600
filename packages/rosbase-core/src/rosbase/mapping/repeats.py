"""Finds an object of JSON that has a key twice; decoders let the last one win, in silence."""

import json
from collections.abc import Iterator
from typing import Any

__all__ = ["OF_NUMBERS", "known_forms", "repeated_key"]

OF_NUMBERS = b"0123456789.-+eE"
"""What numbers consist of. Without it, the messages of a stream look the same: their form."""

known_forms: set[bytes] = set()
"""Forms of messages in which no key stands twice."""

_MOST_FORMS = 64
_LONGEST_FORM = 4096


def repeated_key(frame: bytes, payload: Any) -> str | None:
    """Return a key that stands twice in an object of a frame, or None.

    Args:
        frame: Valid JSON.
        payload: What a decoder has made of it.

    Raises:
        RecursionError: It is nested too deeply.
    """
    # Each key has a colon. So has many a text, such as a date: then it is looked up.
    key = _look_up(frame) if frame.count(b":") > _count_keys(payload) else None
    form = frame.translate(None, OF_NUMBERS)
    if key is None and len(form) <= _LONGEST_FORM and _is_telling(form, payload):
        if len(known_forms) >= _MOST_FORMS:
            known_forms.clear()
        known_forms.add(form)
    return key


class _RepeatedError(Exception):
    """Ends the decoding."""


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
    """Whether no message of the same form has a key twice: none that differs in digits only."""
    if b"\\" in form:
        return False
    removed = str.maketrans("", "", OF_NUMBERS.decode())
    return all(len({key.translate(removed) for key in o}) == len(o) for o in _objects(payload))


def _objects(payload: Any) -> Iterator[dict[str, Any]]:
    """All objects in a payload, however deep."""
    waiting = [payload]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            yield value
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value
