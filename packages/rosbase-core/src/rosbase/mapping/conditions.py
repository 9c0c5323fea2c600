"""Compile conditions to functions, because they are evaluated for every payload."""

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

from rosbase.mapping.following import MISSING, follow, holds
from rosbase.mapping.paths import Condition, Where

__all__ = ["Pick", "Predicate", "compile_condition", "compile_where"]

Predicate: TypeAlias = Callable[[Any], bool]
"""Whether a value meets a condition."""

Pick: TypeAlias = Callable[[Any], Any]
"""The step of a condition: returns the same as `follow` for a value."""


def compile_condition(condition: Condition) -> Predicate:
    """Return a function with the same result as `holds` for this condition."""
    careful = partial(holds, condition)
    pick = _quick_pick(condition)
    if pick is None:
        return careful

    def meets(value: Any) -> bool:
        return pick(value) is value if value.__class__ is dict else careful(value)

    return meets


def compile_where(where: Where) -> Pick:
    """Return a function with the same result as `follow` for this step."""
    pick = _quick_pick(where.conditions[0]) if len(where.conditions) == 1 else None
    return partial(follow, steps=(where,)) if pick is None else pick


def _quick_pick(condition: Condition) -> Pick | None:
    """Return a quick step for the usual conditions, such as `kind=acc` and `list[0]!=-1`."""
    (steps, *others) = condition.paths
    key = str(steps[0])
    if others or len(steps) > 2 or condition.takes_text:
        return None
    if len(steps) == 1:
        return _pick_by_key(key, condition)
    return _pick_by_index(key, steps[1], condition) if isinstance(steps[1], int) else None


def _pick_by_key(key: str, condition: Condition) -> Pick:
    wanted, is_equal = condition.value, condition.is_equal
    is_bool = isinstance(wanted, bool)
    careful = partial(follow, steps=(Where((condition,)),))

    def pick(value: Any) -> Any:
        if value.__class__ is not dict:
            return careful(value)
        found = value.get(key, MISSING)
        is_same = found == wanted and (found.__class__ is bool) is is_bool
        return value if is_same is is_equal else MISSING

    return pick


def _pick_by_index(key: str, index: int, condition: Condition) -> Pick:
    wanted, is_equal = condition.value, condition.is_equal
    is_bool = isinstance(wanted, bool)
    careful = partial(follow, steps=(Where((condition,)),))

    def pick(value: Any) -> Any:
        if value.__class__ is not dict:
            return careful(value)
        inner = value.get(key)
        if inner is None:
            return MISSING if is_equal else value
        if inner.__class__ is not list or len(inner) <= index:
            return careful(value)
        found = inner[index]
        is_same = found == wanted and (found.__class__ is bool) is is_bool
        return value if is_same is is_equal else MISSING

    return pick
