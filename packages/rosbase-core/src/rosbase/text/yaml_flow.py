"""Read values as they are typed on a command line: YAML or JSON in one line. Pure.

A word without quotes stays a text: the type of the field decides how to read it.
"""

from __future__ import annotations

import re

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

__all__ = ["read_flow"]

_MOST_DEPTH = 64
# Of YAML; Python has more of them.
_WHITE = " \t\r\n"
_BLANKS = re.compile(f"[{_WHITE}]*")
_WORD = re.compile(
    rf"[^,\[\]{{}}:#{_WHITE}'\"]+|:(?=[^{_WHITE}])|[ \t]+(?=[^{_WHITE},\]}}#:])|#|['\"]"
)
_COMMENT = re.compile(f"(?:^|[{_WHITE}])#")
_DOUBLE = re.compile(r'"((?:[^"\\]|\\.)*)"', re.DOTALL)
_SINGLE = re.compile(r"'((?:[^']|'')*)'", re.DOTALL)
_ESCAPE = re.compile(r"\\(x[0-9a-fA-F]{2}|u[0-9a-fA-F]{4}|U[0-9a-fA-F]{8}|.)", re.DOTALL)
_ESCAPED = {
    "0": "\0", "a": "\a", "b": "\b", "t": "\t", "n": "\n", "v": "\v", "f": "\f", "r": "\r",
    "e": "\x1b", "N": "\x85", "_": "\xa0", "L": "\u2028", "P": "\u2029",
}  # fmt: skip
_NOTHING = ("", "~", "null", "Null", "NULL")
_NUMBERS = {".inf": "inf", "+.inf": "inf", "-.inf": "-inf", ".nan": "nan"}


def read_flow(text: str) -> Any:
    """Return the value: dicts, lists, texts and None.

    `data: a, b` without brackets is a field with all of the rest.

    Raises:
        ValueError: It is neither; the text says where.
    """
    reader = _Reader(text)
    value = reader.pair_or_value()
    reader.expect_end()
    return value


class _Reader:
    """Goes through a text from its beginning."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._depth = 0

    def pair_or_value(self) -> Any:
        """Read the whole: a value, or a field without the brackets around it."""
        if self._next() in ("{", "[", ""):
            return self._value()
        key = self._scalar()
        if self._next() != ":":
            return key
        self._at += 1
        if self._next() in ("{", "[", "'", '"'):
            return {key: self._value()}
        text = self._rest()
        return {key: None if text in _NOTHING else _NUMBERS.get(text.lower(), text)}

    def _rest(self) -> str:
        """Take all that is left, up to a comment."""
        text = _COMMENT.split(self._text[self._at :], maxsplit=1)[0].strip(_WHITE)
        if re.search(f":([{_WHITE}]|$)", text):
            raise self._error("a colon too many")
        self._at = len(self._text)
        return text

    def expect_end(self) -> None:
        if rest := self._next():
            raise self._error(f"{rest!r} is too much")

    def _value(self) -> Any:
        self._depth += 1
        if self._depth > _MOST_DEPTH:
            raise self._error("it is nested too deeply")
        first = self._next()
        if first == "{":
            self._at += 1
            value: Any = self._fields("}")
        elif first == "[":
            self._at += 1
            value = self._items()
        else:
            value = self._scalar()
        self._depth -= 1
        return value

    def _fields(self, end: str) -> dict[str, Any]:
        fields: dict[str, Any] = {}
        while self._next() != end:
            key = self._scalar()
            if not isinstance(key, str):
                raise self._error("a field has a name")
            if self._next() != ":":
                raise self._error(f"a colon and a value must follow {key}")
            self._at += 1
            if key in fields:
                raise self._error(f"{key} is there twice")
            fields[key] = self._value()
            self._comma(end)
        self._at += len(end)
        return fields

    def _items(self) -> list[Any]:
        items = []
        while self._next() != "]":
            items.append(self._value())
            self._comma("]")
        self._at += 1
        return items

    def _comma(self, end: str) -> None:
        found = self._next()
        if found == ",":
            self._at += 1
        elif found != end:
            raise self._error(f"a comma or {end} must follow")

    def _scalar(self) -> Any:
        first = self._next()
        if first in ("'", '"'):
            return self._quoted(_DOUBLE if first == '"' else _SINGLE)
        start = self._at
        while (word := _WORD.match(self._text, self._at)) and not self._is_comment(word[0]):
            self._at = word.end()
        text = self._text[start : self._at]
        return None if text in _NOTHING else _NUMBERS.get(text.lower(), text)

    def _is_comment(self, word: str) -> bool:
        return word == "#" and self._text[self._at - 1 : self._at] in ("", " ", "\t")

    def _quoted(self, pattern: re.Pattern[str]) -> str:
        found = pattern.match(self._text, self._at)
        if found is None:
            raise self._error("a quote is not closed")
        self._at = found.end()
        if pattern is _SINGLE:
            return found[1].replace("''", "'")
        return _ESCAPE.sub(_unescaped, found[1])

    def _next(self) -> str:
        """Skip blanks; return the next character, empty at the end."""
        blanks = _BLANKS.match(self._text, self._at)
        self._at = blanks.end() if blanks else self._at
        return self._text[self._at : self._at + 1]

    def _error(self, what: str) -> ValueError:
        return ValueError(f"{self._text[:80]!r}, character {self._at + 1}: {what}")


def _unescaped(found: re.Match[str]) -> str:
    code = found[1]
    if len(code) > 1:
        return chr(int(code[1:], 16))
    return _ESCAPED.get(code, code)
