"""Follow paths through a payload that may hold any value anywhere."""

from typing import Any, Final

from rosbase.mapping.paths import Condition, Scalar, Steps, Where, show_steps
from rosbase.mapping.reals import number_in
from rosbase.mapping.rejects import Reject

__all__ = ["MISSING", "Missing", "follow", "holds", "matching", "resolve"]


class Missing:
    """Type of MISSING."""

    def __repr__(self) -> str:
        return "MISSING"


MISSING: Final = Missing()
"""The result of a path that leads to nothing."""


def follow(value: object, steps: Steps) -> Any:
    """Return the value at the end of the steps, MISSING, or a `Reject`. Never raises.

    The result is a `Reject` if several elements of a list meet a condition.

    Args:
        value: The value at which the steps begin.
        steps: Keys, indices and conditions; not `[*]`.
    """
    for step in steps:
        if isinstance(value, dict):
            value = _in_object(value, step)
        elif isinstance(value, list):
            value = _in_list(value, step)
        else:
            return value if isinstance(value, Reject) else MISSING
    return value


def resolve(value: object, paths: tuple[Steps, ...]) -> Any:
    """Return the value of the first path that leads to something, or MISSING."""
    for steps in paths:
        found = follow(value, steps)
        if found is not MISSING:
            return found
    return MISSING


def holds(condition: Condition, value: object) -> bool:
    """Return whether the value is an object or a list that meets the condition."""
    if not isinstance(value, (dict, list)):
        return False
    found = resolve(value, condition.paths)
    return (found is not MISSING and _is_same(found, condition)) is condition.is_equal


def matching(elements: list[Any], where: Where) -> list[Any]:
    """Return the elements that meet all conditions."""
    return [e for e in elements if all(holds(condition, e) for condition in where.conditions)]


def _in_object(value: dict[str, Any], step: object) -> Any:
    if isinstance(step, Where):
        return value if all(holds(condition, value) for condition in step.conditions) else MISSING
    return value.get(str(step), MISSING) if isinstance(step, (str, int)) else MISSING


def _in_list(value: list[Any], step: object) -> Any:
    if isinstance(step, int):
        return value[step] if step < len(value) else MISSING
    if not isinstance(step, Where):
        return MISSING
    found = matching(value, step)
    if len(found) > 1:
        return Reject("surplus", f"{len(found)} elements meet {show_steps((step,))}")
    return found[0] if found else MISSING


def _is_same(found: object, condition: Condition) -> bool:
    wanted: Scalar = condition.value
    if condition.takes_text and isinstance(found, str):
        return number_in(found) == wanted
    # In JSON, unlike in Python, true is not 1.
    return isinstance(found, bool) is isinstance(wanted, bool) and bool(found == wanted)
