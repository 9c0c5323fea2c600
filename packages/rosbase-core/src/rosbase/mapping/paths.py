"""Where in a payload a value stands: `a.b`, `list[0].x`, or alternatives `new|old`."""

import re
from collections.abc import Sequence
from typing import Any, Final, TypeAlias

from rosbase.errors import MappingError

__all__ = ["MISSING", "Path", "Steps", "follow", "parse_path", "resolve", "variants"]

Steps: TypeAlias = tuple[str | int, ...]
"""The way from the top of a payload to a value: keys of objects, indices of lists."""

Path: TypeAlias = tuple[Steps, ...]
"""Alternatives; the first that leads to something counts."""


class _Missing:
    """The type of MISSING."""

    def __repr__(self) -> str:
        return "MISSING"


MISSING: Final = _Missing()
"""What a path leads to when there is nothing."""

_INDEX = re.compile(r"0|[1-9]\d{0,8}", re.ASCII)
_STEP = re.compile(r"[^.\[\]|]+")


def parse_path(text: str) -> Path:
    """The path that `text` describes. A step of digits is an index, or else such a key.

    Raises:
        MappingError: It is not a path.
    """
    return tuple(_parse_steps(alternative.strip(), text) for alternative in text.split("|"))


def _parse_steps(alternative: str, text: str) -> Steps:
    steps = re.sub(r"\[(\d+)\]", r".\1", alternative).removeprefix(".").split(".")
    if not all(_STEP.fullmatch(step) for step in steps):
        raise MappingError(f"{text!r} is not a path such as accel.x or data[0]")
    return tuple(int(step) if _INDEX.fullmatch(step) else step for step in steps)


def variants(paths: Sequence[Path], what: str) -> list[list[Steps]]:
    """The paths of a quantity, one list for each alternative: they are taken together.

    Raises:
        MappingError: Some have more alternatives than others.
    """
    if len({len(path) for path in paths}) > 1:
        raise MappingError(f"all paths of {what} must have the same number of alternatives")
    return [list(steps) for steps in zip(*paths, strict=True)]


def follow(payload: object, steps: Steps) -> Any:
    """What the steps lead to, or MISSING. Never raises."""
    value = payload
    for step in steps:
        value = _child(value, step)
    return value


def resolve(payload: object, path: Path) -> Any:
    """What the path leads to, or MISSING. Never raises."""
    for steps in path:
        value = follow(payload, steps)
        if value is not MISSING:
            return value
    return MISSING


def _child(value: object, step: str | int) -> object:
    if isinstance(value, dict):
        return value.get(str(step), MISSING)
    if isinstance(value, list) and isinstance(step, int) and step < len(value):
        return value[step]
    return MISSING
