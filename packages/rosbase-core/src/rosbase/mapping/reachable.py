"""Refuse paths that lead to nothing in every payload, because conditions exclude them."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from attrs import evolve

from rosbase.errors import MappingError
from rosbase.mapping.paths import Condition, Each, Steps, Where, show_condition, show_steps

__all__ = ["check_reachable"]


def check_reachable(
    select: Sequence[Condition], ways: Mapping[str, Sequence[Sequence[Steps]]]
) -> None:
    """Check that each way can lead to a number of a payload that is selected.

    Args:
        select: The conditions that a payload must meet.
        ways: By quantity: for each alternative the ways to its components.

    Raises:
        MappingError: A way cannot.
    """
    for name, alternatives in ways.items():
        for steps in (steps for components in alternatives for steps in components):
            against = _excluding(select, steps)
            if against is not None:
                raise MappingError(
                    f"{name} is never at {show_steps(steps)}: there, "
                    f"{show_condition(against)} holds"
                )
            if isinstance(steps[-1], Where):
                raise MappingError(
                    f"{name} is never at {show_steps(steps)}: objects and lists meet conditions, "
                    "numbers do not"
                )


class _Known(NamedTuple):
    """A condition that a payload, or a part of it, meets."""

    written: Condition
    here: Condition
    """The same with its path from the value that a way has come to."""


def _excluding(select: Sequence[Condition], steps: Steps) -> Condition | None:
    """Return the condition that excludes a way."""
    known = [_Known(condition, condition) for condition in select]
    for step in steps:
        for one in known:
            if one.here.is_equal and one.here.paths == ((),):
                # The value is a text or a number, and has no inside.
                return one.written
        if isinstance(step, Where):
            added = [_Known(condition, condition) for condition in step.conditions]
            # A list may meet conditions too; then the step selects an element of it.
            if not any(map(_is_of_object, known)):
                known = []
            for one in known:
                if any(one.here.contradicts(condition) for condition in step.conditions):
                    return one.written
            known += added
        else:
            known = [] if isinstance(step, Each) else _behind(step, known)
    return None


def _is_of_object(known: _Known) -> bool:
    """Return whether only an object meets the condition."""
    paths = known.here.paths
    return known.here.is_equal and all(path and isinstance(path[0], str) for path in paths)


def _behind(step: str | int, known: Sequence[_Known]) -> list[_Known]:
    """Return what the conditions say of the value behind a step."""
    return [
        _Known(one.written, evolve(one.here, paths=tuple(path[1:] for path in one.here.paths)))
        for one in known
        if all(path[:1] == (step,) for path in one.here.paths)
    ]
