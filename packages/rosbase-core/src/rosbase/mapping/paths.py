"""Paths as data: keys, indices, conditions and `[*]`.

`rosbase.mapping.path_text` parses paths, `rosbase.mapping.following` follows them.
"""

import json
import re
from collections.abc import Sequence
from typing import Final, NamedTuple, TypeAlias

from attrs import field, frozen

from rosbase.errors import MappingError

__all__ = [
    "ALONE",
    "BARE_KEY",
    "EACH",
    "INDEX",
    "Condition",
    "Each",
    "Path",
    "Scalar",
    "Step",
    "Steps",
    "Way",
    "Where",
    "show_condition",
    "show_steps",
    "variants",
]

_SIGN = r"""\s.\[\]|"'=<>!,*+/\\(){}:;?&%#^~`\u2018-\u201f"""

BARE_KEY: Final = re.compile(rf"[^{_SIGN}-][^{_SIGN}]*")
"""A key that is written without quotes. Signs of other path languages need them."""

ALONE: Final = frozenset({"$", "@"})
"""The top of a payload in JSONPath. As a key, each needs quotes."""

INDEX: Final = re.compile(r"0|[1-9]\d{0,8}", re.ASCII)
"""An index of a list, or the same digits as the key of an object."""

Scalar: TypeAlias = "str | int | float | bool | None"
"""The value in a condition: a JSON value other than an object or a list."""


class Each:
    """The type of EACH."""

    def __repr__(self) -> str:
        return "EACH"


EACH: Final = Each()
"""The step `[*]`: every element of a list, one for each sample."""


def _as_json(value: Scalar) -> tuple[bool, Scalar]:
    # In JSON, unlike in Python, true is not 1.
    return isinstance(value, bool), value


@frozen
class Condition:
    """A condition such as `name=acc`, on an object or a list."""

    paths: "tuple[Steps, ...]"
    """Alternatives of keys and indices. The first that leads to something counts."""
    value: Scalar = field(eq=_as_json)
    is_equal: bool = True
    """False for `!=`, which also holds if the path leads to nothing."""
    takes_text: bool = False
    """Whether a text that is a JSON number counts as that number."""

    def contradicts(self, other: "Condition") -> bool:
        """Return whether the two conditions never hold for the same value."""
        if self.paths != other.paths:
            return self.is_equal and other.is_equal and self._is_inside(other)
        is_same = _as_json(self.value) == _as_json(other.value)
        if self.is_equal and other.is_equal:
            return not is_same and not self._may_be_text(other) and not other._may_be_text(self)
        return is_same and self.is_equal is not other.is_equal

    def _may_be_text(self, other: "Condition") -> bool:
        """Return whether the other condition may want this one's number as a text."""
        return self.takes_text and isinstance(other.value, str)

    def _is_inside(self, other: "Condition") -> bool:
        """Return whether one path leads into the value of the other, which has no inside."""
        if len(self.paths) > 1 or len(other.paths) > 1:
            return False
        short, long = sorted((self.paths[0], other.paths[0]), key=len)
        return short == long[: len(short)]


class Where(NamedTuple):
    """Conditions as a step: they select the element of a list, or must hold for an object."""

    conditions: tuple[Condition, ...]


Step: TypeAlias = str | int | Where | Each
"""A key; an index, or a key that looks like one; conditions; or every element."""

Steps: TypeAlias = tuple[Step, ...]
"""The way from the top of a payload to a value."""


class Way(NamedTuple):
    """One alternative of a path."""

    steps: Steps
    sign: float = 1.0
    """-1.0 to negate the number."""


Path: TypeAlias = tuple[Way, ...]
"""Alternatives. The first that leads to something counts."""


def variants(paths: Sequence[Path], what: str) -> list[tuple[Way, ...]]:
    """Return the ways of a quantity by alternative, because alternatives belong together.

    Raises:
        MappingError: Some have more alternatives than others.
    """
    if len({len(path) for path in paths}) > 1:
        raise MappingError(f"all paths of {what} must have the same number of alternatives")
    return list(zip(*paths, strict=True))


def show_steps(steps: Steps) -> str:
    """Return the steps as a user would write them."""
    text = ""
    for step in steps:
        if isinstance(step, (int, Where, Each)):
            text += _show_bracket(step)
        else:
            text += f".{_show_key(step)}" if text else _show_key(step)
    return text


def show_condition(condition: Condition) -> str:
    """Return the condition as a user would write it."""
    path = "|".join(show_steps(steps) for steps in condition.paths)
    value = json.dumps(condition.value, ensure_ascii=False)
    return f"{path}{'=' if condition.is_equal else '!='}{value}"


def _show_bracket(step: int | Where | Each) -> str:
    if isinstance(step, Where):
        return "".join(f"[{show_condition(condition)}]" for condition in step.conditions)
    return f"[{step}]" if isinstance(step, int) else "[*]"


def _show_key(key: str) -> str:
    needs_quotes = INDEX.fullmatch(key) or not BARE_KEY.fullmatch(key) or key in ALONE
    return json.dumps(key, ensure_ascii=False) if needs_quotes else key
