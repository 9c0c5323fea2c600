"""Values of parameters as users write them, read by the declared type and never guessed.

`off` is false for a bool parameter, and text for a string parameter.
"""

import re
from collections.abc import Sequence
from typing import TypeAlias

from attrs import frozen

from rosbase.errors import ParameterError
from rosbase.parameters.checking import check_value
from rosbase.parameters.kinds import ELEMENTS, ParameterKind, ParameterSpec, ParameterValue

__all__ = ["Written", "WrittenText", "from_outside", "parse_text", "parse_written"]


@frozen
class WrittenText:
    """A scalar as written in a file or on a command line."""

    text: str
    is_quoted: bool = False
    """Whether it is in quotes, so that it is text."""
    data: bytes | None = None
    """Bytes of a scalar that is `!!binary` in YAML."""


Written: TypeAlias = WrittenText | tuple[WrittenText, ...]
"""A value as written: a scalar, or the items of a list."""

_TRUTHS = {
    form: truth
    for truth, words in ((True, ("y", "yes", "true", "on")), (False, ("n", "no", "false", "off")))
    for word in words
    for form in (word, word.capitalize(), word.upper())
}

_INTEGER = re.compile(r"[-+]?\d+", re.ASCII)
_HEX = re.compile(r"[-+]?0[xX][0-9a-fA-F]+")
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)
_OCTAL = re.compile(r"[-+]?0\d+", re.ASCII)

# One pair of quotes around a whole item.
_QUOTED = re.compile(r"^([\"'])((?:(?!\1).)*)\1$", re.DOTALL)


def parse_text(spec: ParameterSpec, text: str) -> ParameterValue:
    """Return the value that a user wrote for the parameter, as in `-p name:=text`.

    Raises:
        ParameterError: The text is no value of the parameter's type.
    """
    if spec.kind is ParameterKind.STRING:
        return check_value(spec, text)
    if spec.kind is ParameterKind.BYTE_ARRAY or spec.kind in ELEMENTS:
        items = _items(text)
        if items is None:
            raise ParameterError(
                f"parameter {spec.name}: the list {text[:60]!r} has an open quote or bracket"
            )
        return _parse_items(spec, [WrittenText(item) for item in items])
    return check_value(spec, _scalar(spec, spec.kind, text))


def parse_written(spec: ParameterSpec, written: Written) -> ParameterValue:
    """Return the value of the parameter in YAML, where quotes mark text.

    Raises:
        ParameterError: It is not a value of the parameter's type.
    """
    if isinstance(written, tuple):
        if spec.kind is ParameterKind.BYTE_ARRAY or spec.kind in ELEMENTS:
            return _parse_items(spec, written)
        return check_value(spec, [item.text for item in written])
    if written.data is not None and spec.kind is ParameterKind.BYTE_ARRAY:
        return check_value(spec, written.data)
    is_text = ELEMENTS.get(spec.kind, spec.kind) is ParameterKind.STRING
    if written.is_quoted and not is_text:
        return check_value(spec, written.text)
    return parse_text(spec, written.text)


def from_outside(spec: ParameterSpec, value: object) -> ParameterValue:
    """Return the value of a parameter whose type a tool has guessed.

    If only some texts are allowed, `False` can only mean `off`. A list of mixed elements comes
    as text.

    Raises:
        ParameterError: It is not a value of the parameter's type.
    """
    if isinstance(value, (bool, int)) and spec.kind is ParameterKind.STRING:
        meant = [choice for choice in spec.choices if _means(choice, value)]
        if len(meant) == 1:
            return meant[0]
    if isinstance(value, str) and (spec.kind is ParameterKind.BYTE_ARRAY or spec.kind in ELEMENTS):
        return parse_text(spec, value)
    return check_value(spec, value)


def _means(text: str, value: float) -> bool:
    """Return whether YAML reads the text as that bool or number."""
    if isinstance(value, bool):
        return _TRUTHS.get(text) is value
    return bool(_INTEGER.fullmatch(text)) and int(text) == value


def _parse_items(spec: ParameterSpec, items: Sequence[WrittenText]) -> ParameterValue:
    if spec.kind is ParameterKind.BYTE_ARRAY:
        found: list[object] = []
        for item in items:
            if item.data is None:
                found.append(_item(spec, ParameterKind.INTEGER, item))
            else:
                found.extend(item.data)
        return check_value(spec, found)
    return check_value(spec, [_item(spec, ELEMENTS[spec.kind], item) for item in items])


def _item(spec: ParameterSpec, kind: ParameterKind, item: WrittenText) -> bool | float | str:
    is_text = kind is ParameterKind.STRING or item.is_quoted
    return item.text if is_text else _scalar(spec, kind, item.text)


def _scalar(spec: ParameterSpec, kind: ParameterKind, text: str) -> bool | float | str:
    """Return the bool or number in the text; the text itself if it is of another kind."""
    text = text.strip()
    if kind is ParameterKind.BOOL and text in _TRUTHS:
        return _TRUTHS[text]
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    # Longer numbers mean nothing here, and Python refuses to convert some of them.
    if len(text) < 400:
        if _OCTAL.fullmatch(text):
            raise ParameterError(
                f"parameter {spec.name}: {text} is octal in YAML; write {int(text)}, if it is meant"
            )
        if _INTEGER.fullmatch(text):
            return int(text)
        if _HEX.fullmatch(text):
            return int(text, 16)
        if _NUMBER.fullmatch(text):
            return float(text)
    return text


def _items(text: str) -> list[str] | None:
    """Split a list such as `[a, 'b, c', d[0, 1]]` at commas outside quotes and inner brackets.

    Return None if its first bracket, or a quote within it, is not closed.
    """
    pieces, is_open = _pieces(text)
    is_list = len(pieces) == 1 and _closes_last(pieces[0])
    if is_list and not is_open:
        pieces, is_open = _pieces(pieces[0][1:-1])
    if is_open and text.lstrip().startswith("["):
        return None
    return [_QUOTED.sub(r"\2", piece) for piece in pieces if piece]


def _pieces(text: str) -> tuple[list[str], bool]:
    """Return the parts between the commas, and whether a quote or bracket is open at the end."""
    pieces, depth, quote = [""], 0, ""
    for sign in text:
        if quote:
            quote = "" if sign == quote else quote
        elif sign == '"' or (sign == "'" and not pieces[-1].strip()):
            # An apostrophe may also stand within a text.
            quote = sign
        else:
            depth += (sign == "[") - (sign == "]")
        if sign == "," and not quote and depth <= 0:
            pieces.append("")
        else:
            pieces[-1] += sign
    return [piece.strip() for piece in pieces], bool(quote) or depth > 0


def _closes_last(text: str) -> bool:
    """Return whether the first bracket of a text is closed by its last one."""
    depth = 0
    for at, sign in enumerate(text):
        depth += (sign == "[") - (sign == "]")
        if depth <= 0:
            return at > 0 and at == len(text) - 1
    return False
