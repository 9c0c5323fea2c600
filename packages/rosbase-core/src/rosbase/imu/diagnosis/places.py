"""Diagnose a path that leads nowhere: the failing step, the value there, and other places."""

import difflib
import json
from collections.abc import Iterable, Iterator
from itertools import islice, takewhile
from typing import NamedTuple, TypeAlias

from rosbase.imu.diagnosis.cause import shown
from rosbase.imu.diagnosis.json_text import contains_json
from rosbase.mapping import following as mapping
from rosbase.mapping.paths import Each, Step, Steps, Where, show_steps
from rosbase.mapping.rejects import Reject

__all__ = ["Lost", "diagnose_path", "follow"]

_Place: TypeAlias = tuple[str | int, ...]

_MOST_KEYS = 8
_DEEPEST = 4
_MOST_PLACES = 200


class Lost(NamedTuple):
    """Step at which a path leads nowhere."""

    text: str
    """Failing step, and the value found there; half a line."""
    has_hint: bool
    """Whether it says what was meant."""


def diagnose_path(payload: object, steps: Steps) -> Lost | None:
    """Return where a path leads nowhere; return None if it leads to a value.

    Args:
        payload: Payload of the frame.
        steps: Keys, indices and conditions, as a mapping has them.
    """
    value, number = follow(payload, steps)
    return None if number == len(steps) else _instead(payload, value, steps, number)


def follow(value: object, steps: Steps) -> tuple[object, int]:
    """Return the value that the steps lead to, and the number of steps that lead there."""
    for number, step in enumerate(steps):
        if isinstance(step, Each):
            # One element stands for each.
            found = value[0] if isinstance(value, list) and value else mapping.MISSING
        else:
            found = mapping.follow(value, (step,))
        if found is mapping.MISSING or isinstance(found, Reject):
            return value, number
        value = found
    return value, len(steps)


def _instead(payload: object, parent: object, steps: Steps, number: int) -> Lost:
    where, step = show_steps(steps[:number]) or "the payload", steps[number]
    if isinstance(step, Where):
        return _unmet(where, parent, step)
    if isinstance(step, Each):
        is_empty = isinstance(parent, list)
        what = "an empty list" if is_empty else f"{_kind(parent)}; [*] takes a list"
        return Lost(f"{where} is {what}", has_hint=True)
    said = shown(show_steps((step,)))
    if isinstance(parent, dict):
        hint = _dotted(parent, steps[number:]) or _near(parent, step)
        hint = hint or _elsewhere(payload, steps) or _in_text(parent)
        return Lost(f"{where} has no {said}{hint or f', but {_keys(parent)}'}", bool(hint))
    if isinstance(parent, list):
        if not isinstance(step, str):
            return Lost(f"{where} is a list of {len(parent)}, without {said}", has_hint=True)
        inside = parent and follow(parent[0], steps[number:])[1] == len(steps) - number
        hint = f"; its elements have it, such as {where}[0]" if inside else ""
        hint = hint or _elsewhere(payload, steps)
        return Lost(f"{where} is a list, without {said}{hint}", bool(hint))
    if isinstance(parent, str) and contains_json(parent):
        return Lost(f"{where} is a text that holds JSON; send the object itself", has_hint=True)
    return Lost(f"{where} is {_kind(parent)}, without {said}", has_hint=False)


def _unmet(where: str, parent: object, step: Where) -> Lost:
    """Return which condition is not met, and the value to compare."""
    elements = parent if isinstance(parent, list) else [parent]
    condition = step.conditions[0]
    values = [mapping.resolve(element, condition.paths) for element in elements[:_MOST_KEYS]]
    known = [json.dumps(v) for v in values if isinstance(v, (str, int, float, bool))]
    but = f", but {shown(', '.join(known))}" if known else ""
    who = f"no element of {where}" if isinstance(parent, list) else f"{where} does not"
    verb = "meets" if isinstance(parent, list) else "meet"
    return Lost(f"{who} {verb} {shown(show_steps((step,)))}{but}", has_hint=bool(known))


def _dotted(parent: dict[str, object], rest: Steps) -> str:
    """Find a key that is written as the path is, dots included."""
    keys = list(takewhile(lambda step: isinstance(step, (str, int)), rest))
    for count in range(len(keys), 1, -1):
        key = ".".join(str(step) for step in keys[:count])
        if key in parent:
            return f", but a key with dots: write {show_steps((key,))} in the path"
    return ""


def _near(parent: dict[str, object], step: Step) -> str:
    step = str(step)
    alike = [key for key in parent if _plain(key) == _plain(step)]
    alike = alike or difflib.get_close_matches(step, list(islice(parent, _MOST_PLACES)), 1, 0.75)
    return f"; did you mean {shown(alike[0])}?" if alike else ""


def _plain(key: str) -> str:
    return "".join(letter for letter in key.casefold() if letter.isalnum())


def _elsewhere(payload: object, steps: Steps) -> str:
    """Return the place from which the whole path leads on, if there is one."""
    for place, value in islice(_places(payload, (), _DEEPEST), 1, _MOST_PLACES):
        if follow(value, steps)[1] == len(steps):
            return f"; there is one at {shown(show_steps((*place, *steps)))}"
    return ""


def _in_text(parent: dict[str, object]) -> str:
    for key, value in islice(parent.items(), _MOST_KEYS):
        if isinstance(value, str) and contains_json(value):
            return f", but {shown(key)}, a text that holds JSON; send the object itself"
    return ""


def _places(value: object, place: _Place, depth: int) -> Iterator[tuple[_Place, object]]:
    yield place, value
    children: Iterable[tuple[str | int, object]] = ()
    if isinstance(value, dict):
        children = value.items()
    elif isinstance(value, list):
        children = enumerate(value[:2])
    for key, child in children:
        if depth and isinstance(child, (dict, list)):
            yield from _places(child, (*place, key), depth - 1)


def _keys(parent: dict[str, object]) -> str:
    keys = [shown(str(key)) for key in islice(parent, _MOST_KEYS)]
    more = ", ..." if len(parent) > _MOST_KEYS else ""
    return f"{', '.join(keys)}{more}" if keys else "nothing at all"


def _kind(value: object) -> str:
    if value is None:
        return "null"
    if isinstance(value, dict):
        return f"an object of {_keys(value)}"
    if isinstance(value, bool):
        return "true or false"
    return f"the text {shown(value)}" if isinstance(value, str) else "a number"
