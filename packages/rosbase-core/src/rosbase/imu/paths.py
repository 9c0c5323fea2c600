"""Where in a payload a value stands: `a.b`, `list[0].x`, or alternatives `new|old`."""

import re
from typing import Any, Final, TypeAlias

from rosbase.errors import MappingError

__all__ = ["MISSING", "Path", "Steps", "parse_path", "resolve"]

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


def resolve(payload: object, path: Path) -> Any:
    """What the path leads to, or MISSING. Never raises."""
    for steps in path:
        value = payload
        for step in steps:
            value = _child(value, step)
        if value is not MISSING:
            return value
    return MISSING


def _child(value: object, step: str | int) -> object:
    if isinstance(value, dict):
        return value.get(str(step), MISSING)
    if isinstance(value, list) and isinstance(step, int) and step < len(value):
        return value[step]
    return MISSING
