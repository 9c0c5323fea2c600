"""Parse paths and conditions as users write them: `a.b`, `list[0].x`, `new|old`, `kind=imu`."""

import json
import math
import re
from itertools import combinations
from typing import Any

from rosbase.errors import MappingError
from rosbase.mapping.paths import (
    ALONE,
    BARE_KEY,
    EACH,
    INDEX,
    Condition,
    Each,
    Path,
    Scalar,
    Step,
    Steps,
    Way,
    Where,
)

__all__ = ["parse_condition", "parse_path"]

_BLANKS = re.compile(r"\s*")
_PLAIN_VALUE = re.compile(r"""[^\[\]{}"'|=<>]*""")
_NUMBER = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?([eE][-+]?\d+)?", re.ASCII)
_WORDS: dict[str, Scalar] = {"true": True, "false": False, "null": None}
_NEARLY_WORDS = {"None": "null"}
_NEARLY_NUMBER = re.compile(r"[-+]?(?=\.?\d)(?P<whole>\d*)\.?\d*([eE][-+]?\d+)?", re.ASCII)
_QUOTE = 'write keys with other characters in double quotes, such as "accel.x"'


def parse_path(text: str, *, numeric_strings: bool = False) -> Path:
    """Return the path that `text` describes.

    Args:
        text: The path as a user wrote it.
        numeric_strings: Whether its conditions take a text such as "1" as the number.

    Raises:
        MappingError: It is not a path; the message says what to write instead.
    """
    scanner = _Scanner(text, "a path", numeric_strings=numeric_strings)
    ways = [_way(scanner)]
    while scanner.take("|"):
        ways.append(_way(scanner))
    scanner.expect_end(_QUOTE)
    if len({way.steps for way in ways}) < len(ways):
        raise scanner.refuse("two of its alternatives are the same")
    return tuple(ways)


def parse_condition(text: str, *, numeric_strings: bool = False) -> Condition:
    """Return the condition that `text` describes, such as `T=1002` or `kind!=status`.

    Args:
        text: The condition as a user wrote it.
        numeric_strings: Whether it takes a text such as "1002" as the number.

    Raises:
        MappingError: It is not a condition; the message says what to write instead.
    """
    scanner = _Scanner(text, "a condition such as T=1002", numeric_strings=numeric_strings)
    scanner.skip_blanks()
    condition = _condition(scanner, _simple_paths(scanner))
    scanner.expect_end("write the value in double quotes")
    return condition


class _Scanner:
    """A text, and the position of the next character."""

    def __init__(self, text: str, kind: str, *, numeric_strings: bool) -> None:
        self._text = text
        self._kind = kind
        self.numeric_strings = numeric_strings
        self._at = 0

    def refuse(self, why: str) -> MappingError:
        return MappingError(f"{self._text!r} is not {self._kind}: {why}")

    def skip_blanks(self) -> None:
        self.match(_BLANKS)

    def peek(self) -> str:
        """Return the next character; empty at the end."""
        return self._text[self._at : self._at + 1]

    def take(self, sign: str) -> bool:
        """Skip the sign if it comes next; return whether it did."""
        if self._text.startswith(sign, self._at):
            self._at += len(sign)
            return True
        return False

    def match(self, pattern: re.Pattern[str]) -> str:
        """Skip and return the match of the pattern; empty without a match."""
        found = pattern.match(self._text, self._at)
        if found is None:
            return ""
        self._at = found.end()
        return found[0]

    def quoted(self) -> str:
        """Skip and return a text in double quotes, written as in JSON."""
        try:
            value, self._at = json.JSONDecoder().raw_decode(self._text, self._at)
        except json.JSONDecodeError:
            raise self.refuse('a double quote is not closed, or \\ and " lack a \\') from None
        return str(value)

    def expect_end(self, hint: str) -> None:
        self.skip_blanks()
        if self.peek():
            raise self.refuse(
                f"{self.peek()!r} is not expected at character {self._at + 1}; {hint}"
            )


def _way(scanner: _Scanner) -> Way:
    scanner.skip_blanks()
    sign = -1.0 if scanner.take("-") else 1.0
    steps = _steps(scanner)
    if sum(step is EACH for step in steps) > 1:
        raise scanner.refuse("[*] stands twice; one list gives the samples of a message")
    if any(_is_never_met(step) for step in steps):
        raise scanner.refuse("its conditions contradict each other")
    scanner.skip_blanks()
    return Way(steps, sign)


def _is_never_met(step: Step) -> bool:
    return isinstance(step, Where) and any(
        a.contradicts(b) for a, b in combinations(step.conditions, 2)
    )


def _steps(scanner: _Scanner) -> Steps:
    steps: list[Step] = [] if scanner.peek() == "[" else [_first_key(scanner)]
    while True:
        if scanner.take("."):
            steps.append(_key(scanner))
        elif scanner.take("["):
            step = _bracket(scanner)
            if isinstance(step, Where) and steps and isinstance(steps[-1], Where):
                step = Where(steps.pop().conditions + step.conditions)  # type: ignore[union-attr]  # as has just been seen
            steps.append(step)
        else:
            return tuple(steps)


def _first_key(scanner: _Scanner) -> str | int:
    if not scanner.peek():
        raise scanner.refuse("it is empty")
    if scanner.peek() == ".":
        raise scanner.refuse("it begins with a key, not with a dot")
    return _key(scanner)


def _key(scanner: _Scanner) -> str | int:
    if scanner.peek() == '"':
        return scanner.quoted()
    key = scanner.match(BARE_KEY)
    if not key:
        raise scanner.refuse(_why_no_key(scanner.peek()))
    if key in ALONE:
        raise scanner.refuse(
            f"a path begins at the top of the payload without a sign; leave out {key!r}, or write "
            "it in double quotes if it is a key"
        )
    return int(key) if INDEX.fullmatch(key) else key


def _why_no_key(sign: str) -> str:
    if sign in ("", ".", "[", "]", "|"):
        return "a key is missing beside a dot or a bar"
    if sign == "*":
        return "every element of a list is written [*]"
    if sign == "-":
        return f"a minus stands at the beginning, to negate the number; {_QUOTE}"
    return f"{sign!r} is not expected; {_QUOTE}"


def _bracket(scanner: _Scanner) -> Step:
    """Return the step in brackets. The opening bracket has been read."""
    if scanner.take("*"):
        _close(scanner)
        return EACH
    if scanner.peek() == "-":
        raise scanner.refuse("an index counts from 0, or a condition names a key")
    if scanner.peek() in ("]", ""):
        raise scanner.refuse("in brackets stands an index, a * or a condition such as [name=acc]")
    paths = _simple_paths(scanner)
    if not scanner.peek():
        raise scanner.refuse("a ] is missing")
    if scanner.peek() == "]" and len(paths) == 1 and len(paths[0]) == 1:
        scanner.take("]")
        index = paths[0][0]
        if isinstance(index, int):
            return index
        raise scanner.refuse(f"a key stands behind a dot: .{index}, not [{index}]")
    condition = _condition(scanner, paths)
    _close(scanner)
    return Where((condition,))


def _close(scanner: _Scanner) -> None:
    if not scanner.take("]"):
        raise scanner.refuse("a ] is missing, or a value is to be written in double quotes")


def _simple_paths(scanner: _Scanner) -> tuple[Steps, ...]:
    """Return the left side of a condition: alternatives of keys and indices."""
    paths = [_simple_steps(scanner)]
    while scanner.take("|"):
        scanner.skip_blanks()
        paths.append(_simple_steps(scanner))
    return tuple(paths)


def _simple_steps(scanner: _Scanner) -> Steps:
    scanner.skip_blanks()
    steps = _steps(scanner)
    if any(isinstance(step, (Where, Each)) for step in steps):
        raise scanner.refuse("the path of a condition has keys and indices only")
    scanner.skip_blanks()
    return steps


def _condition(scanner: _Scanner, paths: tuple[Steps, ...]) -> Condition:
    is_equal = not scanner.take("!")
    if not scanner.take("="):
        sign = scanner.peek()
        is_odd = sign not in ("", "<", ">", "]") and not BARE_KEY.match(sign)
        hint = f"; {_QUOTE}" if is_odd and is_equal else ""
        raise scanner.refuse(f"a condition is written path=value or path!=value{hint}")
    scanner.skip_blanks()
    value = scanner.quoted() if scanner.peek() == '"' else _plain_value(scanner)
    scanner.skip_blanks()
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return Condition(paths, value, is_equal, takes_text=is_number and scanner.numeric_strings)


def _plain_value(scanner: _Scanner) -> Scalar:
    """Return a number, true, false or null; anything else is a text without quotes."""
    text = scanner.match(_PLAIN_VALUE).strip()
    if not text:
        raise scanner.refuse("the value is missing, or is to be written in double quotes")
    if text in _WORDS:
        return _WORDS[text]
    if not _NUMBER.fullmatch(text):
        return _plain_text(scanner, text)
    try:
        number: Any = json.loads(text)
    except ValueError:
        number = math.inf
    if not math.isfinite(number):
        raise scanner.refuse("the number is too large")
    return float(number) if isinstance(number, float) else int(number)


def _plain_text(scanner: _Scanner, text: str) -> str:
    """Return the text, unless it looks like another value of JSON."""
    word = _NEARLY_WORDS.get(text, text.lower())
    found = _NEARLY_NUMBER.fullmatch(text)
    if word in _WORDS or (found and found["whole"] != text):
        meant = word if word in _WORDS else "the number as in JSON"
        raise scanner.refuse(f'write {meant}, or "{text}" in double quotes for the text')
    return text
